#pragma once

#include <string>
#include <variant>

#include "studio/page_message.h"
#include "studio/render_orders.h"

namespace tessera {

class LiveViews;
class RenderQueue;

/// What threads are to do for an export that is no command line; or why nothing can be done.
std::variant<std::string, ExportFile, ExportView, ExportUnfinished> export_order(
    ClientId client, const page::Export& wish, const LiveViews& views, const RenderQueue& renders);

}  // namespace tessera
