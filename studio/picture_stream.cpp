#include "studio/picture_stream.h"

#include <algorithm>
#include <limits>

namespace tessera {

bool catch_up(WaitingBands& waiting,
              const std::function<std::shared_ptr<PixelSink>(ClientId)>& sink_of) {
  for (auto at = waiting.begin(); at != waiting.end();) {
    const bool is_sent = at->second.send(sink_of(at->first.client).get());
    at = is_sent ? waiting.erase(at) : std::next(at);
  }
  return !waiting.empty();
}

void PictureStream::begin(const ViewId& view, const PassPicture& picture) {
  Shown& shown = views_[view];
  if (shown.whole && shown.of_whole.is_last && shown.of_whole.scene != picture.scene)
    shown.before = shown.whole;
  shown.picture = picture;
  shown.is_torn = shown.is_torn || !shown.done.empty();
  shown.film.reset();
  shown.done.clear();
  shown.waiting.clear();
  if (shown.legend.channel != shown.channel_of(picture)) renew_legend(view, shown);
}

bool PictureStream::renew_legend(const ViewId& view, Shown& shown) {
  const ViewChannel channel = shown.channel_of(shown.of_whole);
  const auto aov = aov_of(channel);
  Legend legend{.channel = channel};
  // Until there is a whole picture tiles have the colours of the one before.
  if (shown.whole && (!aov || shown.whole->aovs().has(*aov)))
    legend = legend_of(*shown.whole, channel, shown.output, shown.of_whole.pass.samples);
  if (legend == shown.legend && shown.is_told) return false;
  shown.legend = legend;
  shown.is_told = true;
  if (tell_) tell_(view, legend);
  return true;
}

void PictureStream::add(const ViewId& view, const PassTiles& tiles) {
  const auto at = views_.find(view);
  if (at == views_.end() || at->second.picture.serial != tiles.serial) return;
  Shown& shown = at->second;
  if (!shown.film) shown.film.emplace(tiles.film, tiles.aovs);
  const bool is_behind = !shown.waiting.empty();
  for (const TilePixels& tile : tiles.tiles) {
    shown.film->write(tile.rect, tile.rect.y0, tile.rect.height(), tile.values);
    shown.done.push_back(tile.rect);
    add_piece(view, shown, Layer::pass, tile.rect, 0);
  }
  if (!is_behind) send(view, shown);
}

void PictureStream::finish(const ViewId& view, uint32_t serial, std::shared_ptr<const Film> film,
                           std::shared_ptr<const FullFrame> frame) {
  const auto at = views_.find(view);
  if (at == views_.end() || at->second.picture.serial != serial) return;
  Shown& shown = at->second;
  shown.whole = std::move(film);
  shown.of_whole = shown.picture;
  shown.frame_of_whole = std::move(frame);
  shown.is_torn = false;
  shown.film.reset();
  std::vector<PixelRect> done = std::exchange(shown.done, {});
  const PixelRect& all = shown.whole->rect();
  int64_t pixels = 0;
  for (const PixelRect& rect : done) pixels += rect.area();
  const uint16_t flags = static_cast<uint16_t>(PixelFrame::kLastPieceOfPass |
                                               (shown.picture.is_last ? PixelFrame::kLastPass : 0));
  // Where all tiles were sent an empty last piece tells that the pass is whole.
  const auto has_scale = [&shown] { return shown.legend.channel != ViewChannel::light; };
  const bool had_scale = has_scale();
  const bool is_recoloured = renew_legend(view, shown) && (had_scale || has_scale());
  const bool is_complete = pixels == all.area() && shown.waiting.empty() && !is_recoloured;
  const PixelRect rest = is_complete ? PixelRect{all.x0, all.y0, all.x0, all.y0} : all;
  shown.waiting.clear();
  add_piece(view, shown, Layer::whole, rest, flags);
  send(view, shown);
}

void PictureStream::set_output(const ViewId& view, const OutputSettings& output,
                               ViewChannel channel) {
  const bool is_new = !views_.contains(view);
  Shown& shown = views_[view];
  if (shown.output == output && shown.channel == channel) return;
  shown.output = output;
  shown.channel = channel;
  if (is_new) return;
  renew_legend(view, shown);
  add_all(view, shown);
  add_pinned(view, shown);
  send(view, shown);
}

std::shared_ptr<const Film> PictureStream::pin(const ViewId& view, page::Pin::What what) {
  const auto at = views_.find(view);
  if (at == views_.end()) return nullptr;
  Shown& shown = at->second;
  auto film = what == page::Pin::What::before  ? shown.before
              : what == page::Pin::What::shown ? shown.whole
                                               : nullptr;
  // Where there is none, what is pinned stays.
  if (!film && what != page::Pin::What::none) return nullptr;
  shown.pinned = std::move(film);
  ++last_pin_;
  add_pinned(view, shown);
  send(view, shown);
  return shown.pinned;
}

std::optional<PictureStream::Pair> PictureStream::pair(const ViewId& view) const {
  const auto at = views_.find(view);
  if (at == views_.end() || !at->second.pinned || !at->second.whole) return std::nullopt;
  return Pair{at->second.pinned, at->second.whole, at->second.of_whole.serial};
}

void PictureStream::add_pinned(const ViewId& view, Shown& shown) const {
  shown.pinned_waiting.clear();
  if (!shown.pinned) return;
  const Film& film = *shown.pinned;
  const PixelFrame frame{.kind = PixelFrame::Kind::pinned,
                         .pane = static_cast<uint8_t>(view.pane),
                         .serial = last_pin_,
                         .rect = film.rect(),
                         .picture_width = static_cast<uint16_t>(film.width()),
                         .picture_height = static_cast<uint16_t>(film.height()),
                         .flags = PixelFrame::kLastPieceOfPass};
  shown.pinned_waiting.add(
      frame,
      [&shown, &film](const PixelRect& rect) {
        return channel_pixels(film, rect, shown.legend, shown.output);
      },
      shown.picture.deflate);
}

void PictureStream::forget(const ViewId& view) { views_.erase(view); }

void PictureStream::forget(ClientId client) {
  std::erase_if(views_, [client](const auto& entry) { return entry.first.client == client; });
}

bool PictureStream::catch_up() {
  bool waits = false;
  for (auto& [view, shown] : views_) waits = !send(view, shown) || waits;
  return waits;
}

bool PictureStream::send(const ViewId& view, Shown& shown) const {
  if (shown.waiting.empty() && shown.pinned_waiting.empty()) return true;
  const auto sink = sink_of_(view.client);
  const bool is_sent = shown.waiting.send(sink.get());
  return shown.pinned_waiting.send(sink.get()) && is_sent;
}

void PictureStream::add_all(const ViewId& view, Shown& shown) {
  shown.waiting.clear();
  // A page takes nothing of a pass that is earlier than what it was sent.
  const bool is_covered = shown.last_sent > shown.of_whole.serial;
  if (shown.whole) {
    const uint16_t flags = static_cast<uint16_t>(
        PixelFrame::kLastPieceOfPass | (shown.of_whole.is_last ? PixelFrame::kLastPass : 0));
    add_piece(view, shown, Layer::whole, shown.whole->rect(), is_covered ? uint16_t{0} : flags);
  } else if (shown.is_torn) {
    add_nothing(view, shown);
  }
  shown.is_torn = false;
  for (const PixelRect& rect : shown.done) add_piece(view, shown, Layer::pass, rect, 0);
}

void PictureStream::add_nothing(const ViewId& view, Shown& shown) {
  const PassPicture& picture = shown.picture;
  const PixelRect all{0, 0, picture.width, picture.height};
  const PixelFrame frame{.kind = PixelFrame::Kind::whole,
                         .pane = static_cast<uint8_t>(view.pane),
                         .serial = picture.serial,
                         .rect = all,
                         .picture_width = static_cast<uint16_t>(all.width()),
                         .picture_height = static_cast<uint16_t>(all.height()),
                         .version = picture.version};
  constexpr size_t kBytesPerPixel = 4;
  shown.waiting.add(
      frame,
      [](const PixelRect& part) {
        return std::vector<uint8_t>(kBytesPerPixel * static_cast<size_t>(part.area()));
      },
      picture.deflate);
}

void PictureStream::add_piece(const ViewId& view, Shown& shown, Layer layer, const PixelRect& rect,
                              uint16_t flags) {
  // What waits is dropped before either film is.
  const bool is_of_pass = layer == Layer::pass;
  const Film& film = is_of_pass ? *shown.film : *shown.whole;
  const PassPicture& picture = is_of_pass ? shown.picture : shown.of_whole;
  const PassPicture& seen = flags == 0 ? shown.picture : picture;
  shown.last_sent = seen.serial;
  const bool is_whole = rect == film.rect();
  const auto side = [](int pixels) { return static_cast<uint16_t>(pixels); };
  const PixelFrame frame{.kind = is_whole ? PixelFrame::Kind::whole : PixelFrame::Kind::tile,
                         .pane = static_cast<uint8_t>(view.pane),
                         .scale = static_cast<uint8_t>(picture.pass.scale),
                         .serial = seen.serial,
                         .rect = rect,
                         .picture_width = side(film.width()),
                         .picture_height = side(film.height()),
                         .version = seen.version,
                         .samples = static_cast<uint16_t>(std::min<uint32_t>(
                             seen.pass.samples, std::numeric_limits<uint16_t>::max())),
                         .flags = flags};
  shown.waiting.add(
      frame,
      [&shown, &film](const PixelRect& part) {
        return channel_pixels(film, part, shown.legend, shown.output);
      },
      picture.deflate);
}

std::optional<PictureStream::Value> PictureStream::value_at(const ViewId& view, int x,
                                                            int y) const {
  const auto at = views_.find(view);
  if (at == views_.end()) return std::nullopt;
  const Shown& shown = at->second;
  const auto pixel_of = [x, y](const PassPicture& picture) {
    const int px = x / picture.pass.scale, py = y / picture.pass.scale;
    return PixelRect{px, py, px + 1, py + 1};
  };
  const bool is_new = std::any_of(shown.done.begin(), shown.done.end(), [&](const PixelRect& rect) {
    return rect.contains(pixel_of(shown.picture));
  });
  const bool is_whole_seen = shown.whole && !shown.is_torn &&
                             shown.of_whole.width == shown.picture.width &&
                             shown.of_whole.height == shown.picture.height;
  if (x < 0 || y < 0 || (!is_new && !is_whole_seen)) return std::nullopt;
  const Film& film = is_new ? *shown.film : *shown.whole;
  const PassPicture& picture = is_new ? shown.picture : shown.of_whole;
  const PixelRect pixel = pixel_of(picture);
  if (!film.rect().contains(pixel)) return std::nullopt;
  const auto channels = static_cast<size_t>(film.channels());
  const size_t from = (static_cast<size_t>(pixel.y0) * static_cast<size_t>(film.width()) +
                       static_cast<size_t>(pixel.x0)) *
                      channels;
  const auto values = film.values().subspan(from, channels);
  Value value{film.aovs().channel_names(), {values.begin(), values.end()}, {}};
  const std::vector<uint8_t> rgba = channel_pixels(film, pixel, shown.legend, shown.output);
  value.shown.assign(rgba.begin(), rgba.begin() + kFilmChannels);
  return value;
}

PictureStream::Whole PictureStream::whole(const ViewId& view) const {
  const auto at = views_.find(view);
  if (at == views_.end()) return {};
  const Shown& shown = at->second;
  return {.film = shown.whole, .frame = shown.frame_of_whole, .output = shown.output};
}

}  // namespace tessera
