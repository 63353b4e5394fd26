#include "studio/exporter.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "studio/page_answer.h"
#include "studio/picture_files.h"

namespace tessera {

void Exporter::make(ExportFile order, const std::shared_ptr<const Film>& film) {
  if (!film)
    return answer_(refusal(order.client, "export", "", "there is no picture yet", order.number));
  order.picture = picture_of(order.frame, *film);
  make(order);
}

void Exporter::make(const ExportFile& order) {
  FileExported exported = export_file(order, folder_);
  const std::string& name = exported.name;
  if (!exported.failure.empty())
    return answer_(
        refusal(order.client, "export", name, exported.failure, order.number, exported.existing));
  if (!exported.content) {
    return answer_(
        page_answer(order.client, "exported", {{"number", order.number}, {"name", name}}));
  }
  tell_download(order, name, exported.is_shown, exported.content);
  if (exported.statistics.empty()) return;
  tell_download(order, statistics_name(name), false,
                std::make_shared<const std::string>(std::move(exported.statistics)));
}

void Exporter::tell_download(const ExportFile& order, const std::string& name, bool is_shown,
                             std::shared_ptr<const std::string> content) {
  nlohmann::json fields{{"number", order.number}, {"name", name}, {"size", content->size()}};
  // Before its first chunk, which catch_up() sends.
  fields["download"] = downloads_.add(order.client, std::move(content));
  if (is_shown) fields["show"] = true;
  answer_(page_answer(order.client, "exported", std::move(fields)));
}

}  // namespace tessera
