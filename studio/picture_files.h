#pragma once

#include "studio/files/folder.h"
#include "studio/render_orders.h"

namespace tessera {

// Pictures and scenes become files here, on a thread that may take its time. Nothing is thrown:
// what fails is told.

FrameFinished finish_frame(const FinishFrame& order, const Folder& folder);
FileExported export_file(const ExportFile& order, const Folder& folder);

}  // namespace tessera
