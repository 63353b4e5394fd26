#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "base/owned_descriptor.h"

namespace tessera {

/// Frames whose scenes nobody shall build again in this process, and the signals by which that
/// ended it, by frame_id as of JobStart.
using CrashedFrames = std::map<std::string, int>;

/// Lets a worker outlive its crashes. The handler of a signal such as SIGSEGV starts the program
/// anew in the same process (execve): it keeps its process id, parent, arguments and standard
/// streams, and has none of the memory and threads that were there. What it has to know of the time
/// before is in this record, in shared memory that it finds by a descriptor: what each thread was
/// doing, and which frames have crashed it.
class CrashRecord {
 public:
  /// A record of its own.
  CrashRecord();
  /// That of the program before this one in this process. Throws usage_error where the descriptor
  /// is of no record.
  explicit CrashRecord(int descriptor);
  ~CrashRecord();
  CrashRecord(const CrashRecord&) = delete;
  CrashRecord& operator=(const CrashRecord&) = delete;

  /// From here on a crash starts the program anew, by its own arguments and `--crash-record N`,
  /// unless `stop` is set by then: who is told to end ends. A signal that somebody else handles, a
  /// sanitizer say, is left to them; one of a thread whose stack has overflowed is survived where
  /// the thread has a SignalStack. Call at most once, by the thread that serves the socket; both
  /// must live as long as the process.
  void start_anew_after_crashes(const std::atomic<bool>& stop);

  /// How the program before this one ended, for the log; nothing: it is the first.
  const std::optional<std::string>& last_crash() const { return last_crash_; }
  /// How many times in a row it crashed without having traced a tile.
  uint32_t crashes_in_vain() const;
  CrashedFrames crashed_frames() const;

  enum class Activity : uint32_t { none, build, trace };
  /// While it lives, the calling thread, number `thread` of those that build and trace, does that.
  /// Costs nanoseconds.
  class Note {
   public:
    Note(CrashRecord* record, int thread, Activity activity, const std::string& frame_id);
    ~Note();
    Note(const Note&) = delete;
    Note& operator=(const Note&) = delete;

   private:
    CrashRecord* record_;  ///< null: nothing is noted
    int thread_;
  };
  /// A tile is traced: crashes before it do not count any more.
  void note_traced();

  struct Shared;  ///< for the handler

 private:
  void map();
  void take_up_crash();

  OwnedDescriptor file_;
  Shared* shared_ = nullptr;
  std::optional<std::string> last_crash_;
};

}  // namespace tessera
