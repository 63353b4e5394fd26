#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "coordinator/web/farm_monitor.h"
#include "coordinator/web/metrics_text.h"
#include "proto/wire/scene_codec.h"
#include "web/http_message.h"
#include "web/log_ring.h"
#include "web/web_access.h"

namespace tessera {

/// What the web server answers: the page, /api/v1, /metrics, /healthz and /readyz. Used by one
/// thread, the server's, but for set_access(); what is made for one is kept for all that ask for
/// the same.
class WebApi {
 public:
  struct Parts {
    std::shared_ptr<FarmMonitor> monitor;
    std::shared_ptr<const LogRing> log;  ///< null: no log
    WebAccess access;
    const std::atomic<bool>* stopping = nullptr;  ///< from then on it is not ready any more
  };
  explicit WebApi(Parts parts) : parts_(std::move(parts)) {}

  void handle(const HttpRequest& request, const HttpReply& reply);
  /// Who may see the page from now on. The one function for other threads.
  void set_access(WebAccess access);
  const WebCounts& counts() const { return counts_; }

 private:
  using Body = std::shared_ptr<const std::string>;
  /// What a text was made of, and it.
  struct Made {
    std::shared_ptr<const void> of;
    Body body;
  };

  HttpResponse health() const;
  HttpResponse readiness() const;
  HttpResponse metrics() const;
  void handle_api(const HttpRequest& request, const HttpReply& reply);
  void handle_job(const HttpRequest& request, const std::string& rest, const HttpReply& reply);
  void show_frame(uint64_t job, uint32_t frame, const std::string& what, const HttpRequest& request,
                  const HttpReply& reply);
  void show_trace(uint64_t job, uint32_t frame, const HttpReply& reply);
  void show_picture(uint64_t job, uint32_t frame, const HttpReply& reply);
  void show_scene(uint64_t job, uint32_t frame, SceneEncoding form, const HttpReply& reply);
  /// Replies that too many ask where the coordinator does not take the question.
  void ask(FarmMonitor::Question question, const HttpReply& reply);
  void tell_news(const HttpRequest& request, const HttpReply& reply);
  void order(uint64_t job, const std::string& what, const HttpRequest& request,
             const HttpReply& reply);
  HttpResponse preview(uint64_t job, uint32_t frame, const FrameShown& shown,
                       const std::string& known);
  HttpResponse log(const HttpRequest& request) const;
  /// `make` is called where `of` is not what the text of that name was made of last.
  template <typename Make>
  Body shared(const std::string& name, std::shared_ptr<const void> of, Make make);

  std::mutex access_mutex_;  ///< of parts_.access
  Parts parts_;
  WebCounts counts_;
  std::map<std::string, Made> made_;  ///< by its kind and frame
};

}  // namespace tessera
