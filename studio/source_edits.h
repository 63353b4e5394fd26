#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "studio/latest_requests.h"
#include "studio/open_documents.h"
#include "studio/studio_orders.h"

namespace tessera {

/// Keeps pages told of what their documents' texts describe, and passes on what they ask of those
/// texts. A state machine like OpenDocuments. Not thread-safe.
class SourceEdits {
 public:
  /// All must outlive this. `orders` is where orders are put.
  SourceEdits(StudioOrders& orders, LatestRequests& requests, const OpenDocuments& documents,
              bool is_read_only)
      : orders_(orders), requests_(requests), documents_(documents), is_read_only_(is_read_only) {}

  void ask(ClientId client, const page::Source& request);
  void take(std::shared_ptr<const FileOutline> outline);
  void leave(ClientId client);
  /// Orders outlines of texts that are others, one a file at a time, and tells pages of those that
  /// are there.
  void tick();

 private:
  struct Outlined {
    std::shared_ptr<const FileOutline> last;  ///< null: none was made yet
    uint64_t ticket = 0;                      ///< of the one that was ordered last
    uint64_t ordered = 0;                     ///< version of that
    bool is_under_way = false;
    std::map<ClientId, uint64_t> told;  ///< tickets of outlines
  };

  void tell(Outlined& outlined, const OpenDocuments::Readers& readers);

  StudioOrders& orders_;
  LatestRequests& requests_;
  const OpenDocuments& documents_;
  bool is_read_only_;
  uint64_t last_ticket_ = 0;
  std::map<std::string, Outlined> outlined_;  ///< by file
};

}  // namespace tessera
