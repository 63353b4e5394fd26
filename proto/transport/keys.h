#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// A key of Curve25519, public or secret.
using Key = std::array<uint8_t, 32>;

/// Who has the secret key is whom the public one names.
struct KeyPair {
  Key public_key{};
  Key secret_key{};
};

/// A new one, from the system's randomness.
KeyPair make_key_pair();
/// The pair of that secret key.
KeyPair key_pair_of(const Key& secret_key);

/// 64 lower-case hexadecimal digits, which no shell takes for anything else.
std::string key_text(const Key& key);
/// Nothing for any other text than key_text() makes.
std::optional<Key> parse_key(std::string_view text);

/// What `tessera keygen` writes as secret key file, and its inverse. `file` is for the usage_error
/// that is thrown for any other text; the key itself is in no message.
std::string secret_key_file(const KeyPair& keys, std::string_view name);
KeyPair parse_secret_key_file(std::string_view text, const std::string& file);
/// A file of several secret keys, at least one, such as enrolment tokens; errors as above.
/// `comment` is a line for people.
std::string secret_keys_file(std::span<const KeyPair> keys, std::string_view comment);
std::vector<KeyPair> parse_secret_keys_file(std::string_view text, const std::string& file);

}  // namespace tessera
