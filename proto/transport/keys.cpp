#include "proto/transport/keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sodium.h>

#include "base/error.h"
#include "base/hex.h"
#include "proto/transport/text_lines.h"

namespace tessera {

static_assert(crypto_box_PUBLICKEYBYTES == sizeof(Key) && crypto_box_SECRETKEYBYTES == sizeof(Key));

KeyPair make_key_pair() {
  if (sodium_init() < 0) throw render_error("there is no randomness for a key");
  KeyPair keys;
  crypto_box_keypair(keys.public_key.data(), keys.secret_key.data());
  return keys;
}

KeyPair key_pair_of(const Key& secret_key) {
  KeyPair keys{{}, secret_key};
  crypto_scalarmult_base(keys.public_key.data(), keys.secret_key.data());
  return keys;
}

std::string key_text(const Key& key) { return hex_text(key); }

std::optional<Key> parse_key(std::string_view text) {
  Key key;
  if (!parse_hex(text, key)) return std::nullopt;
  return key;
}

std::string secret_key_file(const KeyPair& keys, std::string_view name) {
  return fmt::format(
      "# The secret key of {}: whoever can read it can be {}.\n"
      "secret {}\n",
      name, name, key_text(keys.secret_key));
}

KeyPair parse_secret_key_file(std::string_view text, const std::string& file) {
  constexpr char kExpected[] = "the line 'secret KEY' of a file that 'tessera keygen' wrote";
  std::optional<KeyPair> keys;
  for (const TextLine& line : text_lines(text)) {
    const bool good = !keys && line.words.size() == 2 && line.words[0].text == "secret";
    const auto key = good ? parse_key(line.words[1].text) : std::nullopt;
    if (!key) {
      throw usage_error(fmt::format("{}: this is no secret key; expected {}",
                                    SourcePlace{file, line.number, line.words[0].column}.str(),
                                    kExpected));
    }
    keys = key_pair_of(*key);
  }
  if (!keys) throw usage_error(fmt::format("{}: no key; expected {}", file, kExpected));
  return *keys;
}

}  // namespace tessera
