#include "studio/picks.h"

#include <algorithm>
#include <span>
#include <utility>

#include "job/job.h"
#include "studio/page_answer.h"
#include "studio/pixel_frame.h"
#include "studio/view_panes.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

Json json_of(const SourceLink& link) {
  Json json{{"kind", link.kind}, {"name", link.name}};
  if (!link.file.empty()) json["file"] = link.file;
  if (!link.entity.empty()) json["entity"] = link.entity;
  if (link.version != 0) json["version"] = link.version;
  if (link.begin && link.end) {
    json["line"] = link.begin->line;
    json["column"] = link.begin->column;
    json["end_line"] = link.end->line;
    json["end_column"] = link.end->column;
  }
  return json;
}

/// The values of the pixel from the first channel of the AOV on.
std::span<const float> values_of(const Film& film, Aov aov, int x, int y) {
  const auto row = static_cast<size_t>(y - film.rect().y0) * static_cast<size_t>(film.width());
  const size_t pixel = row + static_cast<size_t>(x - film.rect().x0);
  return film.values().subspan(pixel * static_cast<size_t>(film.channels()) +
                               static_cast<size_t>(film.aovs().first_channel(aov)));
}

}  // namespace

void Picks::ask(PartQuestion question, const LiveViews::Seen& seen, const PixelRect& crop,
                int priority, LiveViews& views) {
  // Who asks again does not wait for the answer before.
  for (auto at = asked_.begin(); at != asked_.end();) {
    const bool is_old = at->second.view == question.view && at->second.whole == question.whole;
    if (is_old) orders_.push_back(EndPass{at->first});
    at = is_old ? asked_.erase(at) : std::next(at);
  }
  auto options = std::make_shared<RenderOptions>(*seen.options);
  options->crop = crop;
  options->aovs =
      AovSet().with(Aov::depth).with(Aov::position).with(Aov::origin).with(Aov::primitive);
  // Light is not looked at, and the surface that counts is that in the middle of the pixel.
  options->integrator = "depth";
  options->samples_per_pixel = 1;
  options->target_error = 0;
  options->min_samples.reset();
  options->pattern = "center";
  options->pinhole = true;
  options->denoise = false;
  question.serial = views.new_serial();
  question.reading = seen.reading;
  question.deflate = deflate_;
  orders_.push_back(TraceAside{{.serial = question.serial,
                                .reading = seen.reading,
                                .options = std::move(options),
                                .camera = seen.camera,
                                .pass = {.scale = 1, .samples = 1},
                                .priority = priority}});
  asked_.emplace(question.serial, std::move(question));
}

void Picks::pick(ClientId client, const page::Pick& pick, LiveViews& views) {
  const ViewId view{client, pick.pane};
  const auto seen = views.seen(view);
  if (!seen || pick.x >= seen->width || pick.y >= seen->height) return;
  ask({.view = view, .x = pick.x, .y = pick.y}, *seen, {pick.x, pick.y, pick.x + 1, pick.y + 1},
      kPickPriority, views);
}

void Picks::parts(ClientId client, const page::Parts& parts, LiveViews& views) {
  const ViewId view{client, parts.pane};
  const auto seen = views.seen(view);
  if (!seen) return;
  ask({.view = view, .whole = true}, *seen, {0, 0, seen->width, seen->height}, kPartsPriority,
      views);
}

void Picks::take(const PassEnd& end) {
  auto asked = asked_.extract(end.serial);
  if (asked.empty()) return;
  PartQuestion& question = asked.mapped();
  if (end.film) {
    orders_.push_back(TellParts{std::move(question), end.film});
  } else if (!question.whole && end.how == PassEnd::How::failed) {
    orders_.push_back(refusal(question.view.client, "pick", question.reading->file,
                              end.why ? end.why->what() : "it failed"));
  }
}

void Picks::leave(ClientId client) {
  for (const auto& [serial, question] : asked_)
    if (question.view.client == client) orders_.push_back(EndPass{serial});
  std::erase_if(asked_, [client](const auto& each) { return each.second.view.client == client; });
}

ScenePart part_at(const Film& film, int x, int y) {
  ScenePart part;
  const auto nodes = values_of(film, Aov::origin, x, y);
  for (size_t i = 0; i < part.nodes.size(); ++i) part.nodes[i] = static_cast<uint32_t>(nodes[i]);
  part.primitive = static_cast<uint32_t>(values_of(film, Aov::primitive, x, y)[0]);
  return part;
}

SendText picked_answer(const PartQuestion& question, const Film& film, SourceMap& map) {
  const ScenePart part = part_at(film, question.x, question.y);
  const SourceChain chain = map.chain(part);
  Json links = Json::array();
  for (const SourceLink& link : chain.links) links.push_back(json_of(link));
  Json fields{{"pane", question.view.pane}, {"x", question.x}, {"y", question.y},
              {"chain", std::move(links)},  {"at", chain.at},  {"version", map.reading().version}};
  if (part.primitive > 0) {
    const auto point = values_of(film, Aov::position, question.x, question.y);
    fields["point"] = {point[0], point[1], point[2]};
    fields["depth"] = values_of(film, Aov::depth, question.x, question.y)[0];
  }
  return page_answer(question.view.client, "picked", std::move(fields));
}

PartPicture part_picture(const PartQuestion& question, const Film& film, SourceMap& map) {
  std::map<ScenePart, uint32_t> numbers;
  std::map<std::string, size_t> link_numbers;  // by what they say
  Json links = Json::array(), chains = Json::array();
  const auto number_of = [&](ScenePart part) {
    part.primitive = 0;
    if (part.nodes[0] == 0) return uint32_t{0};
    const auto [at, is_new] = numbers.try_emplace(part, static_cast<uint32_t>(numbers.size() + 1));
    if (!is_new) return at->second;
    const SourceChain chain = map.chain(part);
    Json entries = Json::array();
    for (const SourceLink& link : chain.links) {
      Json json = json_of(link);
      const auto [known, is_other] = link_numbers.try_emplace(json.dump(), links.size());
      if (is_other) links.push_back(std::move(json));
      entries.push_back(known->second);
    }
    chains.push_back({{"links", std::move(entries)}, {"at", chain.at}});
    return at->second;
  };
  std::vector<uint8_t> bytes;
  bytes.reserve(static_cast<size_t>(film.rect().area()) * sizeof(uint32_t));
  for (int y = film.rect().y0; y < film.rect().y1; ++y) {
    for (int x = film.rect().x0; x < film.rect().x1; ++x) {
      const uint32_t number = number_of(part_at(film, x, y));
      for (int shift = 0; shift < 32; shift += 8)
        bytes.push_back(static_cast<uint8_t>(number >> shift));
    }
  }
  const PixelFrame frame{.kind = PixelFrame::Kind::parts,
                         .pane = static_cast<uint8_t>(question.view.pane),
                         .serial = question.serial,
                         .rect = film.rect(),
                         .picture_width = static_cast<uint16_t>(film.width()),
                         .picture_height = static_cast<uint16_t>(film.height()),
                         .version = static_cast<uint32_t>(map.reading().version),
                         .samples = 1,
                         .flags = PixelFrame::kLastPieceOfPass};
  return {frame, std::move(bytes),
          page_answer(question.view.client, "parts",
                      {{"pane", question.view.pane},
                       {"serial", question.serial},
                       {"version", map.reading().version},
                       {"links", std::move(links)},
                       {"chains", std::move(chains)}})};
}

}  // namespace tessera
