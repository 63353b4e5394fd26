#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "studio/file_tasks.h"
#include "studio/page_message.h"
#include "studio/pass_runner.h"
#include "studio/picture_stream.h"
#include "studio/render_orders.h"
#include "studio/scene_reading.h"
#include "studio/source_request.h"

namespace tessera {

// What the studio's state machines ask of the threads around them. Plain values.

/// What a page asked, of the requests that it makes one at a time.
struct RequestId {
  ClientId client = 0;
  std::string kind;  ///< of the message
  friend auto operator<=>(const RequestId&, const RequestId&) = default;
};
/// A thread has done what was ordered for it.
struct RequestDone {
  RequestId request;
};

struct SendText {
  ClientId client = 0;
  std::string text;
};
/// Why a WebSocket is closed, by the numbers of RFC 6455; the page knows the last one as its own.
namespace close_code {
constexpr uint16_t kDone = 1000, kPolicyViolation = 1008, kTryLater = 1013, kNoToken = 4401;
}  // namespace close_code
struct CloseClient {
  ClientId client = 0;
  uint16_t code = close_code::kDone;
  std::string reason;
};
/// The pixels of the view are of that pass from now on, which is to be traced.
struct TracePass {
  ViewId view;
  PassOrder order;
  PassPicture picture;
};
struct EndPass {
  uint32_t serial = 0;
};
struct ChangeOutput {
  ViewId view;
  OutputSettings output;
  ViewChannel channel = ViewChannel::light;
};
/// What came of ChangeOutput where the view goes on showing what it shows as before.
struct OutputRefused {
  ViewId view;
  OutputSettings output;
  std::string why;
};
struct ForgetView {
  ViewId view;
};
struct PinPicture {
  ViewId view;
  page::Pin::What what = page::Pin::What::shown;
};
struct ComparePictures {
  ViewId view;
  bool deflate = false;
};
/// Where the entities of a scene are.
struct TellCenters {
  ClientId client = 0;
  std::shared_ptr<const SceneReading> reading;
};
struct ProbePixel {
  ViewId view;
  int x = 0, y = 0;
};
/// A pass that no view shows.
struct TraceAside {
  PassOrder order;
};
/// What a page asked: which part of the scene a pixel shows, or all pixels.
struct PartQuestion {
  ViewId view;
  uint32_t serial = 0;  ///< of the pass that tells
  bool whole = false;   ///< all pixels
  int x = 0, y = 0;     ///< else that one
  std::shared_ptr<const SceneReading> reading{};
  bool deflate = false;
};
struct TellParts {
  PartQuestion question;
  std::shared_ptr<const Film> film;
};
using StudioOrder =
    std::variant<SendText, CloseClient, FileTask, ReadOrder, TracePass, EndPass, ChangeOutput,
                 ForgetView, PinPicture, ComparePictures, TellCenters, ProbePixel, SourceOrder,
                 OutlineOrder, TraceFrame, EndFrame, FinishFrame, ExportFile, ExportView,
                 ExportUnfinished, TraceAside, TellParts>;
using StudioOrders = std::vector<StudioOrder>;

}  // namespace tessera
