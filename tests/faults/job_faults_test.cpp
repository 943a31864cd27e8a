// A whole small job out of core, with something going wrong at every point of it. Whatever happens:
// the output is the old one or the new one, whole; and the same command with --resume ends in the
// same bytes, or is refused with a reason.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <thread>

#include "base/error.h"
#include "base/reservation_seam.h"
#include "base/resources.h"
#include "driver/simplify.h"
#include "faults/refused_memory.h"
#include "io/files/file_system.h"
#include "io/store/manifest.h"
#include "support/faulty_file_system.h"
#include "support/mesh_file.h"
#include "support/temp_dir.h"
#include "support/volatile_disk.h"
#include "support/vtu_text.h"

namespace tetfusion {
namespace {

using testing::bytes_of;
using testing::FaultyFileSystem;
using testing::TempDir;
using testing::VolatileDisk;
namespace fs = std::filesystem;

// Points that are tried, and what became of the job.
struct Trials {
  int points = 0;
  int unharmed = 0;  // it ended well all the same
  int gone_on = 0;   // with the work that was kept
  int anew = 0;
  int refused = 0;  // to go on, with a reason; then begun anew in an empty folder
};

// The parameter: of how many points one is tried. The first ones and the last ones always are.
class JobFaults : public ::testing::TestWithParam<int> {
 protected:
  // With the way back, which is one more output.
  explicit JobFaults(bool progressive = false) {
    request_.input = folder_.file("in.vtu");
    fs::create_directory(disk_);
    request_.output = disk_ + "/out.vtu";
    if (progressive) request_.progressive = disk_ + "/out.tfp";
    request_.behaviour.reduction = 0.4;
    request_.behaviour.chunk_tets = 150;
    request_.performance.threads = 1;
    request_.performance.on_disk = true;
    testing::rich_box(5).write(request_.input);
    simplify(request_);
    new_ = bytes_of(request_.output);
    if (progressive) new_progressive_ = bytes_of(request_.progressive);
    FaultyFileSystem system;
    simplify(request_);
    calls_ = system.calls();
  }
  ~JobFaults() override {
    set_thread_count(0);
    std::cout << ::testing::UnitTest::GetInstance()->current_test_info()->name() << ": "
              << trials_.points << " points tried of a job of " << calls_ << " calls; "
              << trials_.unharmed << " did no harm, " << trials_.gone_on << " were gone on with, "
              << trials_.anew << " begun anew, " << trials_.refused << " refused with a reason\n";
  }

  // The old output is there, and nothing else.
  void reset() {
    fs::remove_all(disk_);
    fs::create_directory(disk_);
    testing::write_file(request_.output, kOld);
    if (!request_.progressive.empty()) testing::write_file(request_.progressive, kOld);
    request_.performance.resume = false;
  }

  // Whether it ended well. An error must be one that a user can read.
  bool run(bool* gone_on = nullptr, int* code = nullptr) {
    has_hint_ = false;
    RunContext context;
    context.notice = [&](std::string_view text) {
      if (gone_on != nullptr && text.find("going on after") != text.npos) *gone_on = true;
    };
    try {
      simplify(request_, context);
      return true;
    } catch (const Error& e) {
      const std::string_view said = e.what();
      EXPECT_NE(said, "");
      has_hint_ = said.find("with --resume goes on") != said.npos;
      EXPECT_TRUE(e.code() == ErrorCode::kIo || e.code() == ErrorCode::kUsage ||
                  e.code() == ErrorCode::kMemory || e.code() == ErrorCode::kBadInput)
          << e.what();
      if (code != nullptr) *code = e.exit_code();
    } catch (const std::bad_alloc&) {  // the command says so, with exit code 5
      if (code != nullptr) *code = 5;
    }
    return false;
  }

  void expect_old_or_new(bool ended_well) {
    const auto expect = [&](const std::string& path, const std::string& expected) {
      const std::string found = fs::exists(path) ? bytes_of(path) : "";
      EXPECT_TRUE(found == expected || (!ended_well && found == kOld)) << path << found.size();
    };
    expect(request_.output, new_);
    if (request_.progressive.empty()) return;
    expect(request_.progressive, new_progressive_);
    // Where the output takes the input's place, the way back is all that is left of that.
    EXPECT_TRUE(bytes_of(request_.output) == kOld ||
                bytes_of(request_.progressive) == new_progressive_);
  }

  // What a user does next.
  void go_on(bool ended_well) {
    ++trials_.points;
    expect_old_or_new(ended_well);
    if (ended_well) {
      ++trials_.unharmed;
      return;
    }
    request_.performance.resume = true;
    bool gone_on = false;
    int code = 0;
    const bool has_hint = has_hint_;
    if (run(&gone_on, &code)) {
      ++(gone_on ? trials_.gone_on : trials_.anew);
      EXPECT_TRUE(gone_on || !has_hint) << "there was nothing to go on with";
    } else {
      ++trials_.refused;
      EXPECT_TRUE(code == 2 || code == 4) << code;
      expect_old_or_new(false);
      fs::remove_all(request_.output + ".tetfusion");
      EXPECT_TRUE(run());
    }
    expect_old_or_new(true);
    for (const auto& entry : fs::directory_iterator(disk_)) {
      EXPECT_TRUE(entry.path() == request_.output || entry.path() == request_.progressive ||
                  entry.path().extension() == ".part")
          << entry.path();
    }
  }

  // At every point that is to be tried.
  void at_every_call(const std::function<void(std::int64_t)>& attempt) {
    for (std::int64_t n = 0; n < calls_; ++n) {
      if (n % GetParam() != 0 && n + 3 < calls_) continue;
      reset();
      attempt(n);
      if (HasFailure()) FAIL() << "at call " << n;
    }
    EXPECT_GT(trials_.points, 0);
  }

  void with_fault_at_every_call(
      const std::function<void(FaultyFileSystem*, std::int64_t)>& set_up) {
    at_every_call([&](std::int64_t n) {
      bool well = false;
      {
        FaultyFileSystem system;
        set_up(&system, n);
        well = run();
        EXPECT_TRUE(well || system.struck());
      }
      go_on(well);
    });
  }

  // Does a manifest say that there is something which no loss of power takes?
  bool says_durable(const std::string& manifest) const {
    testing::write_file(folder_.file("manifest"), manifest);
    const std::string path = folder_.file("manifest");
    const Manifest log(Descriptor(file_system().openat(AT_FDCWD, path.c_str(), O_RDONLY, 0)), path);
    return std::any_of(log.commits().begin(), log.commits().end(),
                       [](const Commit& commit) { return commit.durable; });
  }

  // What was durable is gone on with.
  void lose_power_at_every_call(VolatileDisk::Keeps keeps) {
    int kept = 0;
    at_every_call([&](std::int64_t n) {
      bool well = false;
      std::string manifest;
      {
        VolatileDisk disk(disk_);
        n % 2 == 0 ? disk.die(n) : disk.die_torn(n);
        well = run() && !disk.struck();  // who is dead tells nobody that all is well
        const std::string path = request_.output + ".tetfusion/manifest";
        if (fs::exists(path) && bytes_of(request_.output) == kOld) manifest = bytes_of(path);
        disk.lose_power(keeps, static_cast<std::uint64_t>(n));
        has_hint_ = false;  // nobody has heard it
      }
      const bool durable = says_durable(manifest);
      kept += durable ? 1 : 0;
      const int gone_on = trials_.gone_on;
      go_on(well);
      EXPECT_TRUE(!durable || trials_.gone_on > gone_on) << "the work was lost";
    });
    EXPECT_GT(kept, 0);
  }

  static constexpr const char* kOld = "the old output";
  TempDir folder_ = TempDir::in_memory();
  std::string disk_ = folder_.file("disk");
  SimplifyRequest request_;
  std::string new_, new_progressive_;
  std::int64_t calls_ = 0;
  bool has_hint_ = false;  // the last run has said how to go on
  Trials trials_;
};

TEST_P(JobFaults, ACallFails) {
  with_fault_at_every_call([](FaultyFileSystem* system, std::int64_t n) { system->fail(n, EIO); });
}

TEST_P(JobFaults, ACallFindsTheDiskFull) {
  with_fault_at_every_call(
      [](FaultyFileSystem* system, std::int64_t n) { system->fail(n, ENOSPC); });
}

TEST_P(JobFaults, ATransferIsCutShort) {
  with_fault_at_every_call([](FaultyFileSystem* system, std::int64_t n) { system->cut_short(n); });
}

TEST_P(JobFaults, TheProcessIsKilled) {
  with_fault_at_every_call([](FaultyFileSystem* system, std::int64_t n) { system->die(n); });
}

TEST_P(JobFaults, TheProcessIsKilledWhileItWrites) {
  with_fault_at_every_call([](FaultyFileSystem* system, std::int64_t n) { system->die_torn(n); });
}

// What is kept stays when it cannot be read, and any other time it is gone on with.
TEST_P(JobFaults, GoingOnFails) {
  const std::string scratch = request_.output + ".tetfusion", kept = folder_.file("kept");
  reset();
  {
    FaultyFileSystem system;
    system.die(calls_ * 3 / 4);
    EXPECT_FALSE(run());
  }
  fs::copy(scratch, kept);
  request_.performance.resume = true;
  for (std::int64_t n = 0;; n += std::min(GetParam(), 5)) {
    fs::remove_all(scratch);
    fs::copy(kept, scratch);
    testing::write_file(request_.output, kOld);
    bool is_over = false, well = false, gone_on = false;
    {
      FaultyFileSystem system;
      system.fail(n, EIO);
      well = run();
      is_over = !system.struck();
    }
    expect_old_or_new(well);
    if (!well) {
      EXPECT_TRUE(run(&gone_on) && gone_on) << "at call " << n;
      expect_old_or_new(true);
    }
    if (is_over || HasFailure()) break;
    ++trials_.points;
  }
  EXPECT_GT(trials_.points, 10);
}

TEST_P(JobFaults, ThePowerGoesAndTakesAllThatWasNotSynced) {
  lose_power_at_every_call(VolatileDisk::Keeps::kSynced);
}

TEST_P(JobFaults, ThePowerGoesAndTakesBytes) {
  lose_power_at_every_call(VolatileDisk::Keeps::kNames);
}

TEST_P(JobFaults, ThePowerGoesAndTakesNames) {
  lose_power_at_every_call(VolatileDisk::Keeps::kData);
}

TEST_P(JobFaults, ThePowerGoesAndTakesSomeOfAll) {
  lose_power_at_every_call(VolatileDisk::Keeps::kSome);
}

TEST_P(JobFaults, TheDiskFillsUp) {
  // Every call writes less than that on the average.
  const std::int64_t step = 331 * GetParam();
  for (std::int64_t room = 0;; room += step) {
    reset();
    bool well = false;
    {
      FaultyFileSystem system;
      system.fill_up_after(room);
      well = run();
      EXPECT_TRUE(well || system.struck());
    }
    go_on(well);
    if (HasFailure()) FAIL() << "with room for " << room << " bytes";
    if (well) break;
  }
}

// Each kind of call takes its time: the thread that syncs falls behind, or is ahead.
TEST_P(JobFaults, CallsAreSlow) {
  using Call = FaultyFileSystem::Call;
  for (int kind = 0; kind <= static_cast<int>(Call::kAdvise); ++kind) {
    if (kind % std::min(GetParam(), 3) != 0 && kind != static_cast<int>(Call::kSync)) continue;
    reset();
    bool well = false;
    {
      FaultyFileSystem system;
      system.before([&](Call call) {
        if (static_cast<int>(call) == kind)
          std::this_thread::sleep_for(std::chrono::microseconds(500));
      });
      well = run();
    }
    EXPECT_TRUE(well) << kind;
    go_on(well);
  }
}

TEST_P(JobFaults, TheInputIsCutOffUnderUs) {
  const std::string mesh = bytes_of(request_.input);
  const auto time = fs::last_write_time(request_.input);
  at_every_call([&](std::int64_t n) {
    bool well = false;
    {
      FaultyFileSystem system;
      std::atomic<std::int64_t> call = 0;
      system.before([&](FaultyFileSystem::Call) {
        if (call++ != n) return;
        EXPECT_EQ(::truncate(request_.input.c_str(), static_cast<off_t>(mesh.size() / 2)), 0);
      });
      well = run();
    }
    testing::write_file(request_.input, mesh);
    fs::last_write_time(request_.input, time);
    go_on(well);
  });
}

// Of the mesh's memory: small allocations are left alone.
TEST_P(JobFaults, MemoryIsRefused) {
  constexpr std::size_t kSmallest = 2048;
  bool well = false;
  const auto allocations = [&](std::int64_t refused) {
    const testing::RefusedMemory memory(kSmallest, refused);
    well = run();
    return memory.allocations();
  };
  reset();
  const std::int64_t all = allocations(testing::RefusedMemory::kNone);
  EXPECT_TRUE(well);
  const std::int64_t step = std::max<std::int64_t>(1, GetParam() * all / (4 * calls_));
  for (std::int64_t n = 0; n < all; n += step) {
    reset();
    allocations(n);
    go_on(well);
    if (HasFailure()) FAIL() << "at allocation " << n;
  }
}

// Of the budget's reservations.
TEST_P(JobFaults, AReservationIsRefused) {
  class Refusal : public ReservationSeam {
   public:
    explicit Refusal(std::int64_t n) : n_(n), before_(replace_reservation_seam(this)) {}
    ~Refusal() override { replace_reservation_seam(before_); }
    Refusal(const Refusal&) = delete;
    Refusal& operator=(const Refusal&) = delete;
    bool refuses() override { return asked_++ == n_; }
    bool has_refused() const { return asked_ > n_; }

   private:
    const std::int64_t n_;
    ReservationSeam* before_;
    std::atomic<std::int64_t> asked_ = 0;
  };
  for (std::int64_t n = 0;; ++n) {
    reset();
    bool well = false, refused = false;
    int code = 0;
    {
      const Refusal refusal(n);
      well = run(nullptr, &code);
      refused = refusal.has_refused();
    }
    EXPECT_EQ(well, !refused);
    EXPECT_EQ(code, refused ? 5 : 0);
    go_on(well);
    if (HasFailure()) FAIL() << "at reservation " << n;
    if (!refused) break;
  }
  EXPECT_GT(trials_.points, 30);
}

class ProgressiveJobFaults : public JobFaults {
 protected:
  ProgressiveJobFaults() : JobFaults(true) {}
};

TEST_P(ProgressiveJobFaults, ACallFails) {
  with_fault_at_every_call([](FaultyFileSystem* system, std::int64_t n) { system->fail(n, EIO); });
}

TEST_P(ProgressiveJobFaults, TheProcessIsKilledWhileItWrites) {
  with_fault_at_every_call([](FaultyFileSystem* system, std::int64_t n) { system->die_torn(n); });
}

TEST_P(ProgressiveJobFaults, ThePowerGoesAndTakesSomeOfAll) {
  lose_power_at_every_call(VolatileDisk::Keeps::kSome);
}

INSTANTIATE_TEST_SUITE_P(Some, ProgressiveJobFaults, ::testing::Values(97),
                         [](const auto&) { return "Points"; });
INSTANTIATE_TEST_SUITE_P(All, ProgressiveJobFaults, ::testing::Values(1),
                         [](const auto&) { return "Points"; });
INSTANTIATE_TEST_SUITE_P(Some, JobFaults, ::testing::Values(97),
                         [](const auto&) { return "Points"; });
INSTANTIATE_TEST_SUITE_P(All, JobFaults, ::testing::Values(1),
                         [](const auto&) { return "Points"; });

}  // namespace
}  // namespace tetfusion
