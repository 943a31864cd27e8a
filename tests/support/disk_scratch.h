// A scratch folder on disk, and runs in it whose generations can be told from one another.
#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "io/files/file_system.h"
#include "io/store/manifest.h"
#include "io/store/scratch.h"
#include "support/pieces.h"
#include "support/temp_dir.h"

namespace tetfusion::testing {

class DiskScratchTest : public ::testing::Test {
 protected:
  std::unique_ptr<Scratch> open(bool resume = false, const std::string& fingerprint = "mesh: a") {
    ScratchOptions options;
    options.folder = folder_;
    options.fingerprint = fingerprint;
    options.resume = resume;
    return disk_scratch(options);
  }

  // A generation whose pieces and state say its name.
  static std::unique_ptr<PieceStore> run(Scratch* scratch, const std::string& name) {
    auto store = scratch->begin(name);
    add_pieces(store.get(), 0, {{0, name + " 0 to 0"}, {1, std::string(5000, name.back())}});
    add_pieces(store.get(), 3, {{1, name + " 3 to 1"}});
    store->seal();
    const std::string state = "state of " + name;
    scratch->commit(name, std::as_bytes(std::span(state)));
    return store;
  }

  static void keep(Scratch* scratch, const std::string& name) {
    const auto store = scratch->begin(name);
    add_pieces(store.get(), 2, {{1, "of " + name}});
    store->seal();
    scratch->keep(name);
  }

  static void expect_kept(const Checkpoint& checkpoint, const std::vector<std::string>& names) {
    EXPECT_EQ(checkpoint.kept.size(), names.size());
    for (const std::string& name : names) {
      ASSERT_TRUE(checkpoint.kept.contains(name)) << name;
      EXPECT_THAT(pieces_in(*checkpoint.kept.at(name), 1), ::testing::ElementsAre("of " + name));
    }
  }

  static void expect_whole(const std::optional<Checkpoint>& checkpoint, const std::string& name) {
    ASSERT_TRUE(checkpoint.has_value());
    EXPECT_EQ(checkpoint->generation, name);
    EXPECT_EQ(text(checkpoint->state), "state of " + name);
    EXPECT_THAT(pieces_in(*checkpoint->pieces, 0), ::testing::ElementsAre(name + " 0 to 0"));
    EXPECT_THAT(pieces_in(*checkpoint->pieces, 1),
                ::testing::ElementsAre(std::string(5000, name.back()), name + " 3 to 1"));
  }

  std::size_t count_files(const std::string& part) const {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      if (entry.path().filename().string().find(part) != std::string::npos) ++count;
    }
    return count;
  }

  bool is_durable(const std::string& name) const {
    const Manifest manifest(Descriptor(::open((folder_ + "/manifest").c_str(), O_RDWR)),
                            "manifest");
    for (const Commit& commit : manifest.commits()) {
      if (commit.name == name && commit.durable) return true;
    }
    return false;
  }

  static bool soon(const std::function<bool()>& condition) {
    for (int i = 0; i < 1000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  static std::string usage_error(const std::function<void()>& f) {
    try {
      f();
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kUsage);
      return e.what();
    }
    ADD_FAILURE() << "no error";
    return {};
  }

  TempDir dir_ = TempDir::in_memory();
  std::string folder_ = dir_.file("scratch");
};

}  // namespace tetfusion::testing
