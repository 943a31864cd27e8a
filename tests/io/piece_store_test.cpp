#include "io/store/piece_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "io/store/scratch.h"
#include "support/pieces.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

using testing::add_pieces;
using ::testing::ElementsAre;
using ::testing::ElementsAreArray;
using ::testing::IsEmpty;
using testing::pieces_in;
using testing::PieceText;
using testing::TempDir;

// Whatever holds for pieces in memory holds for pieces on disk.
class PieceStores : public ::testing::TestWithParam<const char*> {
 protected:
  PieceStores() {
    if (std::string(GetParam()) == "memory") {
      scratch_ = memory_scratch();
    } else {
      ScratchOptions options;
      options.folder = dir_.file("scratch");
      scratch_ = disk_scratch(options);
    }
  }

  TempDir dir_;
  std::unique_ptr<Scratch> scratch_;
};

TEST_P(PieceStores, ComeBackAsTheyWere) {
  const auto store = scratch_->begin("one");
  add_pieces(store.get(), 7, {{0, "first"}, {2, std::string(10000, 'x')}});
  store->seal();
  EXPECT_THAT(pieces_in(*store, 0), ElementsAre("first"));
  EXPECT_THAT(pieces_in(*store, 1), IsEmpty());
  EXPECT_THAT(pieces_in(*store, 2), ElementsAre(std::string(10000, 'x')));
  EXPECT_THAT(pieces_in(*store, 2), ElementsAre(std::string(10000, 'x')));
  EXPECT_EQ(store->bytes(), 10005u);
  EXPECT_EQ(store->bytes(0), 5u);
  EXPECT_EQ(store->bytes(1), 0u);
}

TEST_P(PieceStores, MayBeUsedOneByOne) {
  const auto store = scratch_->begin("one");
  for (const std::uint32_t source : {3u, 1u, 20u}) {
    add_pieces(store.get(), source, {{5, "from " + std::to_string(source)}, {6, "other"}});
  }
  store->seal();
  for (int times = 0; times < 2; ++times) {
    std::vector<std::string> used;
    store->for_each(5, [&](auto piece) { used.push_back(testing::text(piece)); });
    EXPECT_THAT(used, ElementsAre("from 1", "from 3", "from 20"));
  }
  store->for_each(7, [](auto) { ADD_FAILURE(); });
}

TEST_P(PieceStores, AscendBySource) {
  const auto store = scratch_->begin("one");
  for (const std::uint32_t source : {3u, 1u, 20u, 100u, 0u}) {
    add_pieces(store.get(), source, {{5, "from " + std::to_string(source)}});
  }
  store->seal();
  EXPECT_THAT(pieces_in(*store, 5),
              ElementsAre("from 0", "from 1", "from 3", "from 20", "from 100"));
}

// On disk they are not mapped then, but read.
TEST_P(PieceStores, MayBeMany) {
  const auto store = scratch_->begin("one");
  std::vector<std::string> expected;
  for (std::uint32_t source = 0; source < 700; ++source) {
    const std::string text(1 + source * 37 % 5000, static_cast<char>('a' + source % 26));
    add_pieces(store.get(), source, {{3, text}, {4, "b"}});
    expected.push_back(text);
  }
  store->seal();
  EXPECT_THAT(pieces_in(*store, 3), ElementsAreArray(expected));
  const auto held = store->read(3);
  for (const auto piece : held->pieces()) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(piece.data()) % 64, 0u);
  }
  store->forget(3);
  EXPECT_EQ(held->pieces().back()[0], std::byte{'a' + 699 % 26});
  held->check();
}

TEST_P(PieceStores, LieAtMultiplesOf64) {
  const auto store = scratch_->begin("one");
  for (std::uint32_t source = 0; source < 9; ++source) {
    add_pieces(store.get(), source, {{0, std::string(source * 1111 + 1, 'a')}, {1, "b"}});
  }
  store->seal();
  for (const std::uint32_t bucket : {0u, 1u}) {
    const auto pieces = store->read(bucket);
    for (const auto piece : pieces->pieces()) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(piece.data()) % 64, 0u);
    }
  }
}

TEST_P(PieceStores, MayBeEmpty) {
  const auto store = scratch_->begin("one");
  add_pieces(store.get(), 0, {});
  store->seal();
  store->will_read(0);
  EXPECT_THAT(pieces_in(*store, 0), IsEmpty());
  store->forget(0);
  EXPECT_EQ(store->bytes(), 0u);
  EXPECT_NO_THROW(scratch_->commit("one", {}));
}

TEST_P(PieceStores, OutliveForgetWhileTheyAreHeld) {
  const auto store = scratch_->begin("one");
  add_pieces(store.get(), 0, {{0, "kept"}, {1, "other"}});
  store->seal();
  const auto held = store->read(0);
  store->forget(0);
  EXPECT_EQ(testing::text(held->pieces().front()), "kept");
  EXPECT_NO_THROW(held->check());
  EXPECT_THAT(pieces_in(*store, 0), IsEmpty());
  EXPECT_THAT(pieces_in(*store, 1), ElementsAre("other"));
}

TEST_P(PieceStores, OutliveTheStoreWhileTheyAreHeld) {
  auto store = scratch_->begin("one");
  add_pieces(store.get(), 0, {{0, "kept"}});
  store->seal();
  const auto held = store->read(0);
  store.reset();
  // What is free to go must not be overwritten while it is read.
  const auto next = scratch_->begin("two");
  add_pieces(next.get(), 0, {{0, "over"}});
  EXPECT_EQ(testing::text(held->pieces().front()), "kept");
}

TEST_P(PieceStores, SeveralThreadsAtOnce) {
  constexpr std::uint32_t kSources = 40;
  constexpr std::uint32_t kBuckets = 12;
  const auto piece = [](std::uint32_t source, std::uint32_t bucket) {
    return std::string(1 + (source * 977 + bucket * 331) % 9000,
                       static_cast<char>('a' + (source + bucket) % 26));
  };
  for (const char* name : {"one", "two", "three"}) {
    const auto store = scratch_->begin(name);
    const auto in_threads = [](std::uint32_t count, const auto& work) {
      std::vector<std::thread> threads;
      for (std::uint32_t t = 0; t < 4; ++t) {
        threads.emplace_back([&, t] {
          for (std::uint32_t i = t; i < count; i += 4) work(i);
        });
      }
      for (std::thread& thread : threads) thread.join();
    };
    in_threads(kSources, [&](std::uint32_t source) {
      std::vector<PieceText> pieces;
      for (std::uint32_t b = source % 3; b < kBuckets; b += 1 + source % 2) {
        pieces.push_back({b, piece(source, b)});
      }
      add_pieces(store.get(), source, pieces);
    });
    store->seal();
    if (std::string(name) != "three") scratch_->commit(name, {});
    in_threads(kBuckets, [&](std::uint32_t bucket) {
      std::vector<std::string> expected;
      for (std::uint32_t source = 0; source < kSources; ++source) {
        const std::uint32_t first = source % 3;
        const bool has = bucket >= first && (bucket - first) % (1 + source % 2) == 0;
        if (has) expected.push_back(piece(source, bucket));
      }
      store->will_read(bucket);
      EXPECT_EQ(pieces_in(*store, bucket), expected);
      EXPECT_EQ(pieces_in(*store, bucket), expected);
      store->forget(bucket);
    });
  }
  EXPECT_GT(scratch_->peak_bytes(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Both, PieceStores, ::testing::Values("memory", "disk"),
                         [](const auto& test) { return std::string(test.param); });

TEST(MemoryScratch, CountsWhatIsThereAtOnce) {
  const auto scratch = memory_scratch();
  auto store = scratch->begin("one");
  add_pieces(store.get(), 0, {{0, std::string(1000, 'a')}, {1, std::string(500, 'b')}});
  store->seal();
  EXPECT_EQ(scratch->peak_bytes(), 1500u);
  store->forget(0);
  const auto next = scratch->begin("two");
  add_pieces(next.get(), 0, {{0, std::string(900, 'c')}});
  EXPECT_EQ(scratch->peak_bytes(), 1500u);
  add_pieces(next.get(), 1, {{0, std::string(200, 'c')}});
  EXPECT_EQ(scratch->peak_bytes(), 1600u);
  EXPECT_FALSE(scratch->resume().has_value());
}

// Bytes that are held are not among what is used again.
TEST(MemoryScratch, UsesPagesAgain) {
  const auto scratch = memory_scratch();
  const auto old = scratch->begin("old");
  const std::string held(300'000, 'h');
  add_pieces(old.get(), 0, {{0, std::string(1'000'000, 'a')}, {1, held}, {2, held}});
  old->seal();
  const auto data_of = [](const PieceStore& store, std::uint32_t bucket) {
    return store.read(bucket)->pieces().front().data();
  };
  [[maybe_unused]] const std::byte* const first = data_of(*old, 0);
  const auto reader = old->read(1);
  old->forget(0);
  old->forget(1);
  const auto next = scratch->begin("next");
  std::vector<PieceText> pieces;
  for (std::uint32_t b = 0; b < 6; ++b) {
    pieces.push_back({b, std::string(900'000 - 160'000 * b, static_cast<char>('a' + b))});
  }
  add_pieces(next.get(), 0, pieces);
  next->seal();
#if !defined(__SANITIZE_ADDRESS__)  // which keeps what is freed for a while
  EXPECT_EQ(data_of(*next, 0), first);
#endif
  for (const PieceText& piece : pieces) {
    EXPECT_THAT(pieces_in(*next, piece.bucket), ElementsAre(piece.text));
  }
  EXPECT_EQ(testing::text(reader->pieces().front()), held);
  EXPECT_THAT(pieces_in(*old, 2), ElementsAre(held));
}

}  // namespace
}  // namespace tetfusion
