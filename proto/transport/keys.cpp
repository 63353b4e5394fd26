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
  return secret_keys_file(
      {&keys, 1}, fmt::format("The secret key of {}: whoever can read it can be {}.", name, name));
}

std::string secret_keys_file(std::span<const KeyPair> keys, std::string_view comment) {
  std::string text = fmt::format("# {}\n", comment);
  for (const KeyPair& pair : keys) text += fmt::format("secret {}\n", key_text(pair.secret_key));
  return text;
}

KeyPair parse_secret_key_file(std::string_view text, const std::string& file) {
  const std::vector<KeyPair> keys = parse_secret_keys_file(text, file);
  if (keys.size() == 1) return keys.front();
  throw usage_error(fmt::format("{}: {} secret keys; expected one", file, keys.size()));
}

std::vector<KeyPair> parse_secret_keys_file(std::string_view text, const std::string& file) {
  constexpr char kExpected[] = "lines 'secret KEY' of a file that 'tessera keygen' wrote";
  std::vector<KeyPair> keys;
  for (const TextLine& line : text_lines(text)) {
    const bool good = line.words.size() == 2 && line.words[0].text == "secret";
    const auto key = good ? parse_key(line.words[1].text) : std::nullopt;
    if (!key) {
      throw usage_error(fmt::format("{}: this is no secret key; expected {}",
                                    SourcePlace{file, line.number, line.words[0].column}.str(),
                                    kExpected));
    }
    keys.push_back(key_pair_of(*key));
  }
  if (keys.empty()) throw usage_error(fmt::format("{}: no key; expected {}", file, kExpected));
  return keys;
}

}  // namespace tessera
