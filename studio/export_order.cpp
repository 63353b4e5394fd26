#include "studio/export_order.h"

#include "proto/wire/scene_codec.h"
#include "studio/files/file_kind.h"
#include "studio/files/file_name.h"
#include "studio/live_views.h"
#include "studio/render_queue.h"

namespace tessera {

namespace {

constexpr const char* kNoStatistics =
    "only a full picture that is done has statistics; expected one, or an export without them";

}  // namespace

std::variant<std::string, ExportFile, ExportView, ExportUnfinished> export_order(
    ClientId client, const page::Export& wish, const LiveViews& views, const RenderQueue& renders) {
  if (std::string fault = fault_of_name(wish.name); !fault.empty()) return fault;
  if (wish.statistics && (!wish.job || scene_encoding_of(wish.name))) return kNoStatistics;
  const FileGoal goal{.names = {wish.name},
                      .is_download = wish.is_download,
                      .is_shown = wish.is_shown,
                      .statistics = wish.statistics,
                      .force = wish.force};
  if (scene_encoding_of(wish.name)) {
    auto reading = views.reading_of(client, wish.file);
    if (!reading) return "the scene cannot be read, or no view shows it";
    ExportFile order;
    order.client = client;
    order.number = wish.number;
    order.frame.reading = std::move(reading);
    order.goal = goal;
    return order;
  }
  if (file_kind_of(wish.name) != FileKind::picture)
    return "'" + wish.name + "': no format to write; expected an ending such as .png or .tessera";
  if (!wish.job) return ExportView{client, wish.number, wish.pane, goal};
  auto order = renders.picture(*wish.job);
  if (!order) {
    if (auto unfinished = renders.unfinished_picture(*wish.job)) {
      if (wish.statistics) return kNoStatistics;
      unfinished->client = client;
      unfinished->number = wish.number;
      unfinished->goal = goal;
      return ExportUnfinished{std::move(*unfinished), *wish.job};
    }
  }
  if (!order) return "there is no such picture any more";
  order->client = client;
  order->number = wish.number;
  order->goal = goal;
  return std::move(*order);
}

}  // namespace tessera
