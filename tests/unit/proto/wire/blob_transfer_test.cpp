#include "proto/wire/blob_transfer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <random>

namespace tessera {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

std::vector<std::byte> random_bytes(size_t size) {
  std::mt19937 random(static_cast<uint32_t>(size));
  std::vector<std::byte> bytes(size);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

/// Serves every request until none is made.
void serve(BlobFetch& fetch, const BlobStore& from, BlobStore& to) {
  for (auto requests = fetch.requests({}); !requests.empty(); requests = fetch.requests({})) {
    for (const v1::BlobRequest& request : requests) {
      const auto answer = answer_blob_request(request, from.find(*Digest::parse(request.digest())));
      if (answer.has_blob_chunk()) fetch.on_chunk(answer.blob_chunk(), to);
      if (answer.has_blob_missing()) fetch.on_missing(answer.blob_missing());
    }
  }
}

TEST(BlobFetch, BringsBlobsOfEverySize) {
  BlobStore from, to;
  BlobFetch fetch;
  for (const size_t size : {size_t{0}, size_t{1}, size_t{kBlobChunkBytes},
                            size_t{kBlobChunkBytes} + 1, size_t{20} * kBlobChunkBytes + 5}) {
    fetch.want(from.put(random_bytes(size)), size);
  }
  serve(fetch, from, to);
  EXPECT_TRUE(fetch.finished());
  EXPECT_EQ(fetch.failure(), "");
  EXPECT_EQ(to.size(), from.size());
  for (const auto& [digest, data] : from.all()) EXPECT_EQ(*to.find(digest), *data);
}

TEST(BlobFetch, IsDoneWithAllButTheLastChunksWhenTheLastOneComes) {
  // Else whoever takes messages would be silent for as long as a large blob's digest takes.
  constexpr size_t kChunks = 20;
  BlobStore from, to;
  const auto digest = from.put(random_bytes(kChunks * kBlobChunkBytes - 5));
  BlobFetch fetch;
  fetch.want(digest, kChunks * kBlobChunkBytes - 5);
  for (size_t came = 0; came < kChunks;) {
    auto asked = fetch.requests({});
    // Overtaken on the way.
    std::reverse(asked.begin(), asked.end());
    for (const auto& request : asked) {
      fetch.on_chunk(answer_blob_request(request, from.find(digest)).blob_chunk(), to);
      ++came;
    }
    if (came < kChunks) {
      EXPECT_EQ(fetch.digested_bytes(), came * kBlobChunkBytes);
    }
  }
  EXPECT_TRUE(to.find(digest));
}

TEST(BlobFetch, AsksForFewAtATimeAndAgainForWhatDoesNotCome) {
  BlobStore from, to;
  const auto digest = from.put(random_bytes(20 * kBlobChunkBytes));
  BlobFetch fetch;
  fetch.want(digest, 20 * kBlobChunkBytes);
  const auto first = fetch.requests({});
  EXPECT_EQ(first.size(), 8u);
  EXPECT_TRUE(fetch.requests(seconds(1)).empty());
  EXPECT_EQ(fetch.next_deadline(), Time(seconds(2)));
  EXPECT_EQ(fetch.requests(seconds(2)).size(), 8u);
  const auto chunk = answer_blob_request(first[3], from.find(digest)).blob_chunk();
  fetch.on_chunk(chunk, to);
  EXPECT_EQ(fetch.requests(seconds(2)).size(), 1u);
  // The same again is not counted twice.
  fetch.on_chunk(chunk, to);
  EXPECT_TRUE(fetch.requests(seconds(2)).empty());
}

TEST(BlobFetch, ASlowLineBringsChunksHardlyEverTwice) {
  // One chunk in five seconds, in the order in which they were asked for.
  constexpr size_t kChunks = 90;
  constexpr Time kOne = seconds(5);
  BlobStore from, to;
  const auto digest = from.put(std::vector<std::byte>(kChunks * kBlobChunkBytes));
  BlobFetch fetch;
  fetch.want(digest, kChunks * kBlobChunkBytes);
  std::deque<v1::BlobRequest> line;
  size_t sent = 0, longest = 0;
  Time next = kOne;
  for (Time now{}; !fetch.finished() && sent < 10 * kChunks; now += milliseconds(500)) {
    for (auto& request : fetch.requests(now)) line.push_back(std::move(request));
    longest = std::max(longest, line.size());
    if (now < next || line.empty()) continue;
    next = now + kOne;
    ++sent;
    fetch.on_chunk(answer_blob_request(line.front(), from.find(digest)).blob_chunk(), to);
    line.pop_front();
  }
  EXPECT_TRUE(fetch.finished());
  EXPECT_LE(sent, kChunks * 5 / 2) << "some come twice: how slow it is has to be learnt";
  EXPECT_LE(longest, 32u) << "what waits is bounded";
}

TEST(BlobFetch, AnOutageIsForgottenWithTheNextChunks) {
  BlobStore from, to;
  const auto digest = from.put(random_bytes(30 * kBlobChunkBytes));
  BlobFetch fetch;
  fetch.want(digest, 30 * kBlobChunkBytes);
  const auto answer = [&](const v1::BlobRequest& request) {
    fetch.on_chunk(answer_blob_request(request, from.find(digest)).blob_chunk(), to);
  };
  for (const auto& request : fetch.requests({})) answer(request);
  for (int i = 0; i < 300; ++i) fetch.requests(seconds(i));
  const auto late = fetch.requests(seconds(300));
  ASSERT_FALSE(late.empty()) << "it has not given up asking";
  for (const auto& request : late) answer(request);
  for (const auto& request : fetch.requests(seconds(300))) answer(request);
  EXPECT_FALSE(fetch.requests(seconds(300)).empty());
  EXPECT_EQ(fetch.next_deadline(), Time(seconds(302)));
}

TEST(BlobFetch, TakesChunksInAnyOrder) {
  BlobStore from, to;
  const auto digest = from.put(random_bytes(7 * kBlobChunkBytes + 9));
  BlobFetch fetch;
  fetch.want(digest, 7 * kBlobChunkBytes + 9);
  auto requests = fetch.requests({});
  std::reverse(requests.begin(), requests.end());
  for (const auto& request : requests) {
    fetch.on_chunk(answer_blob_request(request, from.find(digest)).blob_chunk(), to);
  }
  EXPECT_TRUE(to.find(digest));
}

TEST(BlobFetch, NeverKeepsWhatIsNotWhatItsNameSays) {
  BlobStore from, to;
  const auto digest = from.put(random_bytes(1000));
  BlobFetch fetch;
  fetch.want(digest, 1000);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(fetch.failure(), "");
    for (const auto& request : fetch.requests({})) {
      auto chunk = answer_blob_request(request, from.find(digest)).blob_chunk();
      (*chunk.mutable_data())[500] ^= 1;
      fetch.on_chunk(chunk, to);
    }
  }
  EXPECT_FALSE(to.find(digest));
  EXPECT_NE(fetch.failure().find("damaged"), std::string::npos);
}

TEST(BlobFetch, IgnoresChunksThatFitNothing) {
  BlobStore from, to;
  const auto digest = from.put(random_bytes(3 * kBlobChunkBytes));
  BlobFetch fetch;
  fetch.want(digest, 3 * kBlobChunkBytes);
  const auto requests = fetch.requests({});
  const auto sound = answer_blob_request(requests[1], from.find(digest)).blob_chunk();
  for (const uint64_t offset : {uint64_t{1}, ~uint64_t{0}, uint64_t{3} * kBlobChunkBytes}) {
    auto chunk = sound;
    chunk.set_offset(offset);
    fetch.on_chunk(chunk, to);
  }
  auto chunk = sound;
  chunk.mutable_data()->pop_back();
  fetch.on_chunk(chunk, to);
  chunk = sound;
  chunk.set_digest("nonsense");
  fetch.on_chunk(chunk, to);
  chunk.set_digest(Digest::of("another").hex());
  fetch.on_chunk(chunk, to);
  EXPECT_TRUE(fetch.requests({}).empty()) << "all are still on their way";
  for (const auto& request : requests) {
    fetch.on_chunk(answer_blob_request(request, from.find(digest)).blob_chunk(), to);
  }
  EXPECT_TRUE(fetch.finished());
}

TEST(BlobFetch, ABlobThatIsShorterThanWasSaidIsAFailure) {
  BlobStore from, to;
  const auto digest = from.put(random_bytes(1000));
  BlobFetch fetch;
  fetch.want(digest, 1001);
  for (int i = 0; i < 5 && fetch.failure().empty(); ++i) {
    for (const auto& request : fetch.requests(seconds(2 * i))) {
      fetch.on_chunk(answer_blob_request(request, from.find(digest)).blob_chunk(), to);
    }
  }
  EXPECT_NE(fetch.failure().find("1001 bytes"), std::string::npos) << fetch.failure();
}

TEST(BlobFetch, TellsWhoseItIs) {
  BlobFetch fetch(77);
  fetch.want(Digest::of("x"), 1);
  const auto requests = fetch.requests({});
  ASSERT_EQ(requests.size(), 1u);
  EXPECT_EQ(requests[0].submission(), 77u);
  EXPECT_EQ(answer_blob_request(requests[0], nullptr).blob_missing().submission(), 77u);
  const auto blob = make_blob(std::vector<std::byte>(1));
  EXPECT_EQ(answer_blob_request(requests[0], blob).blob_chunk().submission(), 77u);
}

TEST(BlobFetch, ASizeAloneCostsNothing) {
  BlobFetch fetch;
  fetch.want(Digest::of("x"), kMaxBlobBytes);
  EXPECT_EQ(fetch.requests({}).size(), 8u);
  fetch.want(Digest::of("y"), kMaxBlobBytes + 1);
  EXPECT_NE(fetch.failure(), "");
}

TEST(BlobFetch, AMissingBlobIsAFailureThatNamesIt) {
  BlobStore from, to;
  BlobFetch fetch;
  fetch.want(Digest::of("x"), 10);
  serve(fetch, from, to);
  EXPECT_NE(fetch.failure().find(Digest::of("x").hex()), std::string::npos);
}

TEST(BlobServer, NeverReadsPastTheEnd) {
  const auto blob = make_blob(random_bytes(100));
  v1::BlobRequest request;
  request.set_offset(90);
  request.set_length(0xffffffff);
  EXPECT_EQ(answer_blob_request(request, blob).blob_chunk().data().size(), 10u);
  request.set_offset(101);
  EXPECT_TRUE(answer_blob_request(request, blob).has_blob_missing());
  request.set_offset(~uint64_t{0});
  EXPECT_TRUE(answer_blob_request(request, blob).has_blob_missing());
}

TEST(BlobFetch, AsksForAPlaceFirstAndForChunksWhereThereIsNone) {
  BlobStore from, to;
  const auto bytes = random_bytes(3 * kBlobChunkBytes);
  const auto shared = from.put(bytes), sent = from.put(random_bytes(2 * kBlobChunkBytes + 1));
  BlobFetch fetch(0, true);
  fetch.want(shared, bytes.size());
  fetch.want(sent, 2 * kBlobChunkBytes + 1);
  const auto asked = fetch.requests({});
  ASSERT_EQ(asked.size(), 2u);  // nothing more before the answers
  for (const auto& request : asked) EXPECT_TRUE(request.place());
  EXPECT_EQ(fetch.requests(seconds(2)).size(), 2u);  // again: they may be lost
  v1::BlobPlace place;
  place.set_digest(shared.hex());
  EXPECT_EQ(fetch.on_place(place), bytes.size());
  EXPECT_FALSE(fetch.on_place(place));  // the second answer
  place.set_digest(Digest::of("unknown").hex());
  EXPECT_FALSE(fetch.on_place(place));
  fetch.on_loaded(shared, from.find(shared), to);
  fetch.on_loaded(shared, from.find(shared), to);
  EXPECT_EQ(to.find(shared), from.find(shared));
  // A chunk is an answer too.
  fetch.on_chunk(answer_blob_request(asked[1], from.find(sent)).blob_chunk(), to);
  fetch.on_chunk(answer_blob_request(asked[0], from.find(sent)).blob_chunk(), to);
  serve(fetch, from, to);
  EXPECT_TRUE(fetch.finished());
  EXPECT_EQ(*to.find(sent), *from.find(sent));
}

TEST(BlobFetch, APlaceThatIsNoneAndAHeldBlobThatIsNotThereAreFetched) {
  BlobStore from, to;
  const auto one = from.put(random_bytes(2 * kBlobChunkBytes)), two = from.put(random_bytes(10));
  BlobFetch fetch(0, true);
  fetch.want(one, 2 * kBlobChunkBytes);
  fetch.hold(two, 10);
  EXPECT_EQ(fetch.requests({}).size(), 1u);
  v1::BlobPlace place;
  place.set_digest(one.hex());
  ASSERT_TRUE(fetch.on_place(place));
  EXPECT_TRUE(fetch.requests(seconds(5)).empty());
  EXPECT_FALSE(fetch.finished());
  fetch.on_loaded(one, nullptr, to);
  fetch.on_loaded(two, nullptr, to);
  for (const auto& request : fetch.requests({})) {
    EXPECT_EQ(request.place(), request.digest() == two.hex());
    fetch.on_chunk(
        answer_blob_request(request, from.find(*Digest::parse(request.digest()))).blob_chunk(), to);
  }
  serve(fetch, from, to);
  EXPECT_TRUE(fetch.finished());
  EXPECT_EQ(to.size(), 2u);
}

}  // namespace
}  // namespace tessera
