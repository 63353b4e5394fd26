#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "base/error.h"
#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "tests/error_of.h"

namespace tessera {

/// The values of a blob.
template <typename T>
std::vector<T> blob_values(const v1::BlobRef& ref, const BlobStore& blobs) {
  const auto digest = Digest::parse(ref.digest());
  const BlobData data = digest ? blobs.find(*digest) : nullptr;
  if (!data) return {};
  EXPECT_EQ(data->size(), ref.size());
  std::vector<T> values(data->size() / sizeof(T));
  std::memcpy(values.data(), data->data(), values.size() * sizeof(T));
  return values;
}

}  // namespace tessera
