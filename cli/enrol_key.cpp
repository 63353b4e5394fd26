#include "cli/enrol_key.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "base/folder.h"
#include "base/log.h"
#include "base/open_file.h"
#include "base/plural.h"
#include "cli/interrupt.h"
#include "cli/say.h"
#include "client/farm_client.h"
#include "client/refusal.h"
#include "front/farm_connection.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The key of an attempt before this one that was not answered, or a new one, on disk.
KeyPair pending_key(const fs::path& file, const std::string& name) {
  if (fs::exists(file)) return read_secret_key(file.string(), "--enrol");
  const KeyPair keys = make_key_pair();
  write_new_file(file, secret_key_file(keys, name), 0600);
  sync_folder(file.has_parent_path() ? file.parent_path() : fs::path("."));
  return keys;
}

/// What the coordinator says of the request when it is asked by that token. A token that is not let
/// in is one that cannot be used.
v1::EnrolAnswer ask_by(const KeyPair& token, const EnrolOptions& options, const Key& server,
                       const v1::Enrol& request) {
  const auto transport = connect_client(options.endpoint, ClientKeys{token, server});
  FarmClient client(*transport, options.endpoint, interrupted());
  try {
    return client.enrol(request);
  } catch (const RefusedError& error) {
    v1::EnrolAnswer answer;
    answer.set_outcome(v1::EnrolAnswer::TOKEN_USED);
    answer.set_text(error.what());
    return answer;
  } catch (const UnreachableError& error) {
    throw temporary_error(error.what());
  }
}

/// Where several machines have one file of tokens, each begins elsewhere.
std::vector<KeyPair> read_tokens(const std::string& file) {
  std::vector<KeyPair> tokens = parse_secret_keys_file(read_secret_file(file, "--enrol"), file);
  std::random_device random;
  const auto first = static_cast<std::ptrdiff_t>(random() % tokens.size());
  std::rotate(tokens.begin(), tokens.begin() + first, tokens.end());
  return tokens;
}

v1::EnrolAnswer ask(const std::vector<KeyPair>& tokens, const EnrolOptions& options,
                    const Key& server, const v1::Enrol& request) {
  v1::EnrolAnswer answer;
  for (const KeyPair& token : tokens) {
    answer = ask_by(token, options, server, request);
    if (answer.outcome() != v1::EnrolAnswer::TOKEN_USED) break;
  }
  const std::string why = printable(answer.text());
  switch (answer.outcome()) {
    case v1::EnrolAnswer::ENROLLED:
      return answer;
    case v1::EnrolAnswer::TOKEN_USED:
      throw usage_error(
          fmt::format("--enrol: of {} in '{}' none is of use, the last one because {}",
                      counted(tokens.size(), "token"), options.tokens, why));
    case v1::EnrolAnswer::TRY_AGAIN:
      throw temporary_error(fmt::format("the coordinator at {}: {}", options.endpoint, why));
    default:
      throw usage_error(fmt::format("the coordinator at {} refused: {}", options.endpoint, why));
  }
}

}  // namespace

void write_new_file(const fs::path& path, const std::string& text, mode_t mode) {
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  const auto fail = [&path](int cause) {
    throw usage_error(fmt::format(
        "keygen: cannot write '{}': {}", path.string(),
        cause == EEXIST ? "it is there already; expected a new file" : std::strerror(cause)));
  };
  if (file < 0) fail(errno);
  const bool good = write_all(file, std::as_bytes(std::span(text))) && fsync(file) == 0;
  const int cause = errno;
  close(file);
  if (good) return;
  unlink(path.c_str());
  fail(cause);
}

ExitCode enrol_key(const EnrolOptions& options) {
  catch_interrupts();
  configure_logging("warn", "keygen");
  if (fs::exists(options.key_file)) {
    say(stderr, "tessera: '{}' is there already: there is nothing to enrol\n",
        options.key_file.string());
    return ExitCode::done;
  }
  const std::vector<KeyPair> tokens = read_tokens(options.tokens);
  const Key server = read_public_key(options.server_key, "--server-key");
  const fs::path pending = options.key_file.string() + ".new";
  const KeyPair keys = pending_key(pending, options.name);
  v1::Enrol request;
  request.set_public_key(key_text(keys.public_key));
  request.set_name(options.name);
  const v1::EnrolAnswer answer = ask(tokens, options, server, request);
  const std::string line = AllowList::line(
      keys.public_key, {parse_role(answer.role(), options.endpoint), answer.name()});
  std::error_code failure;
  fs::rename(pending, options.key_file, failure);
  if (failure) {
    throw render_error(
        fmt::format("'{}' cannot be renamed: {}", pending.string(), failure.message()));
  }
  write_new_file(fs::path(options.key_file).replace_extension(".pub"), line, 0644);
  say("{}", line);
  return ExitCode::done;
}

}  // namespace tessera
