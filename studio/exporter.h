#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/download_stream.h"
#include "studio/files/folder.h"
#include "studio/render_orders.h"
#include "studio/studio_orders.h"

namespace tessera {

/// Makes files of pictures and scenes: in the folder, or sent to the page. Used by one thread.
class Exporter {
 public:
  /// `answer` is called with what pages are told. Both outlive this.
  Exporter(const Folder& folder, PictureStream::Sinks sink_of, std::function<void(SendText)> answer)
      : folder_(folder), downloads_(std::move(sink_of)), answer_(std::move(answer)) {}

  void make(const ExportFile& order);
  /// The same of a film in place of the order's picture; null: there is none yet.
  void make(ExportFile order, const std::shared_ptr<const Film>& film);
  /// Sends what pages take of their downloads. Returns whether there is more.
  bool catch_up() { return downloads_.catch_up(); }

 private:
  void tell_download(const ExportFile& order, const std::string& name, bool is_shown,
                     std::shared_ptr<const std::string> content);

  const Folder& folder_;
  DownloadStream downloads_;
  std::function<void(SendText)> answer_;
};

}  // namespace tessera
