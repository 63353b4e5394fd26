#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// Results that a worker could not hand in, on disk: for itself, or for the process that takes its
/// place with the same folder. That one goes on under the id of the first, since its leases are
/// that id's, and a coordinator must not take what it traces for a second opinion. One file a
/// worker, "ID.GENERATION.results", locked as long as that lives; frames of proto/wire/frame.h, so
/// that what is damaged or torn, and what follows it, is left out. Used by one thread.
class ResultSpool {
 public:
  /// Whose results these are.
  struct Origin {
    uint64_t worker_id = 0;
    uint64_t session = 0;  ///< above all that it has used
    uint64_t farm = 0;     ///< whose jobs they are of
  };

  /// Takes over what one ended worker of that numerics id left in `folder`, which is of this user
  /// alone; what is older than a day, or of another id, is removed. `budget_bytes` are those of
  /// BlobCache, whose folder it is: blobs make room for results, which never take over 1 GiB.
  ResultSpool(std::filesystem::path folder, uint64_t budget_bytes, std::string numerics_id);
  /// Leaves a file that holds results to whoever comes next.
  ~ResultSpool();
  ResultSpool(const ResultSpool&) = delete;
  ResultSpool& operator=(const ResultSpool&) = delete;

  /// Of what was taken over; nothing: there was none.
  const std::optional<Origin>& origin() const { return origin_; }
  /// Whether it holds results.
  bool empty() const { return file_ < 0; }
  /// Adds a result of the worker that says `hello`, for `farm`; false: it is dropped, since the
  /// budget is used up or it cannot be written, which the log tells, once.
  bool keep(const v1::Hello& hello, uint64_t farm, const v1::Envelope& result);
  /// Gives all results to `take` and holds them no more; those of another farm are dropped. `take`
  /// may call keep(). Returns how many.
  size_t hand_in(uint64_t farm, const std::function<void(v1::Envelope)>& take);
  void clear();

 private:
  void take_over();
  bool create(const v1::Hello& hello, uint64_t farm);
  bool has_room(uint64_t bytes);
  bool append(const v1::Envelope& message);
  void close_file();

  std::filesystem::path folder_, path_;
  uint64_t budget_bytes_;
  std::string numerics_id_;
  std::optional<Origin> origin_;
  int file_ = -1;      ///< locked
  uint64_t size_ = 0;  ///< of it
  uint64_t room_ = 0;  ///< to which it may grow before one looks again
  bool full_ = false;
  uint64_t farm_ = 0;  ///< of its results
  bool complained_ = false;
};

}  // namespace tessera
