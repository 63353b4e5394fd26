// What the page's server answers, without its sockets.
#include "coordinator/web/web_api.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "coordinator/web/png_file.h"
#include "tests/unit/coordinator/service_fixture.h"

namespace tessera::testing {
namespace {

using Json = nlohmann::json;

class WebApiTest : public ServiceTest {
 protected:
  WebApiTest() { coordinator.on_tick({}); }
  void look(Time at) { monitor->look(coordinator, at); }
  HttpResponse send(HttpRequest request) {
    std::optional<HttpResponse> response;
    request.headers.try_emplace("host", "localhost:1");
    api.handle(request, [&](const std::function<HttpResponse()>& make) { response = make(); });
    // Orders wait until the time that those before took is paid for.
    for (int i = 0; i < 100 && !response; ++i) look(clock += milliseconds(100));
    EXPECT_TRUE(response) << request.path;
    return response.value_or(HttpResponse{});
  }
  HttpResponse get(const std::string& target, std::map<std::string, std::string> headers = {}) {
    HttpRequest request{"GET", "", {}, std::move(headers), ""};
    split_target(target, request);
    return send(std::move(request));
  }
  HttpResponse post(const std::string& path, const std::string& body = "{}") {
    return send({"POST", path, {}, {{"content-type", "application/json"}}, body});
  }
  Json json(const std::string& target) {
    const HttpResponse response = get(target);
    EXPECT_EQ(response.status, 200) << target;
    return Json::parse(*response.body);
  }

  Time clock = monotonic_now();
  std::atomic<bool> stopping = false;
  std::shared_ptr<FarmMonitor> monitor = std::make_shared<FarmMonitor>();
  WebApi api{{monitor, nullptr, {}, &stopping}};
};

TEST_F(WebApiTest, TellsNews) {
  look(clock);
  const uint64_t news = json("/api/v1/news").at("news");
  submit(1);
  EXPECT_NE(json("/api/v1/news?after=" + std::to_string(news)).at("news"), news);
  EXPECT_EQ(get("/api/v1/news?after=x").status, 400);
}

TEST_F(WebApiTest, IsReadyFromTheFirstLookUntilItIsToEnd) {
  EXPECT_EQ(get("/healthz").status, 200);
  EXPECT_EQ(get("/readyz").status, 503);
  EXPECT_EQ(get("/api/v1/farm").status, 503);
  look(monotonic_now());
  EXPECT_EQ(get("/readyz").status, 200);
  stopping = true;
  EXPECT_EQ(get("/readyz").status, 503);
  EXPECT_EQ(get("/healthz").status, 200);
  look(monotonic_now() - seconds(60));
  EXPECT_EQ(get("/healthz").status, 503) << "the coordinator's thread hangs";
}

TEST_F(WebApiTest, ServesThePage) {
  EXPECT_THAT(*get("/").body, ::testing::HasSubstr("<title>Tessera</title>"));
  EXPECT_EQ(get("/").type, "text/html; charset=utf-8");
  for (const char* part : {"/page.js", "/page.css", "/api.js", "/icon.svg"}) {
    EXPECT_EQ(get(part).status, 200) << part;
  }
  look(monotonic_now());
  for (const char* none :
       {"/index.html", "/../etc/passwd", "/x", "/api/v1", "/api/v1/", "/api/v2/farm"}) {
    EXPECT_EQ(get(none).status, 404) << none;
  }
}

TEST_F(WebApiTest, TellsJobsAndWorkers) {
  const uint64_t id = submit(1, 5);
  come((uint64_t{1} << 63) - 8, 3);
  look(monotonic_now());
  const Json farm = json("/api/v1/farm");
  EXPECT_EQ(farm["jobs"].size(), 1u);
  EXPECT_EQ(farm["jobs"][0]["state"], "running");
  EXPECT_EQ(farm["workers"][0]["id"], "9223372036854775800") << "which no browser could count";
  EXPECT_EQ(farm["workers"][0]["tiles_held"], 3);
  EXPECT_EQ(json("/api/v1/jobs")["jobs"], farm["jobs"]);
  EXPECT_EQ(json("/api/v1/workers")["workers"], farm["workers"]);
  EXPECT_EQ(json("/api/v1/jobs/" + std::to_string(id))["priority"], 5);
  EXPECT_EQ(json("/api/v1/history")["at"].size(), 1u);
  EXPECT_TRUE(json("/api/v1/log?after=0")["lines"].empty());
  const HttpResponse metrics = get("/metrics");
  EXPECT_EQ(metrics.type, "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_THAT(*metrics.body, ::testing::HasSubstr("tessera_jobs{state=\"running\"} 1\n"));
}

TEST_F(WebApiTest, TellsTilesAndPictures) {
  const uint64_t id = submit(1);
  come(1, 3);
  say("w1", band(assigned().at(0), 0.25f));
  look(monotonic_now());
  const std::string of_job = "/api/v1/jobs/" + std::to_string(id);
  const Json tiles = json(of_job + "/tiles");
  EXPECT_EQ(tiles["tiles"].size(), 4u);
  EXPECT_EQ(tiles["tiles"][0][4], 2) << "done";
  EXPECT_EQ(tiles["workers"][tiles["tiles"][0][5].get<size_t>()], "1");
  EXPECT_EQ(tiles["tiles"][0][8], 1) << "it is in the picture";
  EXPECT_EQ(tiles["tiles"][1][8], 0);
  EXPECT_EQ(tiles["preview"]["rect"], Json({0, 0, 32, 32}));
  const HttpResponse picture = get(of_job + "/preview.png?frame=0");
  ASSERT_EQ(picture.status, 200);
  EXPECT_EQ(picture.type, "image/png");
  EXPECT_EQ(picture.body->substr(1, 3), "PNG");
  const std::string tag = picture.headers.at(0).second;
  EXPECT_EQ(get(of_job + "/preview.png", {{"if-none-match", tag}}).status, 304);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(get(of_job + "/preview.png").body, picture.body) << "the very same bytes";
  }
  EXPECT_EQ(api.counts().previews_encoded, 1u);
  EXPECT_EQ(monitor->work().previews, 1u);
  for (size_t i = 1; i < 4; ++i) say("w1", band(assigned().at(i), 1));
  look(clock += seconds(5));
  EXPECT_EQ(get(of_job + "/preview.png", {{"if-none-match", tag}}).status, 200);
  EXPECT_EQ(Json::parse(*get(of_job + "/trace.json").body)["traceEvents"].size(), 7u);
}

TEST_F(WebApiTest, TakesOrders) {
  const uint64_t id = submit(1);
  look(monotonic_now());
  const std::string of_job = "/api/v1/jobs/" + std::to_string(id);
  EXPECT_EQ(Json::parse(*post(of_job + "/pause").body)["state"], "paused");
  EXPECT_EQ(json(of_job)["state"], "paused");
  EXPECT_EQ(Json::parse(*post(of_job + "/resume").body)["state"], "queued");
  look(monotonic_now());
  EXPECT_EQ(json(of_job)["state"], "running");
  EXPECT_EQ(Json::parse(*post(of_job + "/priority", "{\"priority\": -3}").body)["priority"], -3);
  for (const char* wrong : {"", "{}", "3", "{\"priority\": 1.5}", "{\"priority\": 3000000000}",
                            "{\"priority\": 18446744073709551615}", "{\"priority\": -2147483649}",
                            "{\"priority\": \"1\"}", "[[[[", "{\"priority\": null}"}) {
    EXPECT_EQ(post(of_job + "/priority", wrong).status, 400) << wrong;
  }
  EXPECT_EQ(Json::parse(*post(of_job + "/cancel").body)["state"], "cancelled");
  EXPECT_EQ(post(of_job + "/pause").status, 409);
  EXPECT_EQ(post(of_job + "/cancel").status, 200) << "it is";
  EXPECT_EQ(post("/api/v1/jobs/99/cancel").status, 404);
}

TEST_F(WebApiTest, AJobWaitsForNothingAsSoonAsItIsShownAsCancelled) {
  for (const bool by_page : {true, false}) {
    const uint64_t id = submit(by_page ? 1 : 2);
    look(clock += seconds(1));
    const std::string of_job = "/api/v1/jobs/" + std::to_string(id);
    EXPECT_EQ(json(of_job)["waits_for"], "workers");
    if (by_page)
      post(of_job + "/cancel");
    else
      ask(id, v1::JobQuery::CANCEL, clock);
    Json shown = json(of_job);
    for (int i = 0; i < 100 && shown["state"] != "cancelled"; ++i) {
      EXPECT_EQ(shown["waits_for"], "workers") << "of the same moment as the state";
      look(clock += milliseconds(20));
      shown = json(of_job);
    }
    EXPECT_EQ(shown["state"], "cancelled");
    EXPECT_TRUE(shown["waits_for"].is_null());
  }
}

TEST_F(WebApiTest, RefusesWhatIsNoRequestOfIts) {
  const uint64_t id = submit(1);
  look(monotonic_now());
  const std::string of_job = "/api/v1/jobs/" + std::to_string(id);
  EXPECT_EQ(get(of_job + "/cancel").status, 405) << "reading changes nothing";
  EXPECT_EQ(post(of_job + "/tiles").status, 405);
  EXPECT_EQ(post("/api/v1/farm").status, 405);
  EXPECT_EQ(send({"DELETE", of_job, {}, {}, ""}).status, 405);
  EXPECT_EQ(send({"OPTIONS", of_job, {}, {}, ""}).status, 405) << "no leave for other sites";
  EXPECT_EQ(send({"POST", of_job + "/cancel", {}, {{"content-type", "text/plain"}}, ""}).status,
            415);
  EXPECT_EQ(get("/api/v1/farm", {{"host", "evil.example"}}).status, 421);
  for (const char* frame : {"1", "-1", "x", "", "4294967296"}) {
    EXPECT_EQ(get(of_job + "/tiles?frame=" + frame).status, 400) << frame;
  }
  for (const char* job : {"/api/v1/jobs/", "/api/v1/jobs/0", "/api/v1/jobs/-1", "/api/v1/jobs/1/x",
                          "/api/v1/jobs/99999999999999999999", "/api/v1/jobs/1/tiles/2"}) {
    EXPECT_EQ(get(job).status, 404) << job;
  }
  EXPECT_EQ(get("/api/v1/log?after=x").status, 400);
}

TEST(PngFile, IsWhatWasShown) {
  PreviewImage image{2, 1, {0, 0, 2, 1}, 1, {255, 0, 0, 0, 255, 0}};
  const std::string file = png_file(image);
  EXPECT_EQ(file.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(file.substr(16, 8), std::string("\0\0\0\2\0\0\0\1", 8)) << "width and height";
}

}  // namespace
}  // namespace tessera::testing
