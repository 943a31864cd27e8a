// XXH3, 64 bits: tells damage by accident, not by intent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace tetfusion {

std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed = 0);

// The same, of bytes that come in parts.
class RunningChecksum {
 public:
  RunningChecksum();
  ~RunningChecksum();
  RunningChecksum(const RunningChecksum&) = delete;
  RunningChecksum& operator=(const RunningChecksum&) = delete;

  void add(std::span<const std::byte> bytes);
  std::uint64_t value() const;  // of all that was added so far

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tetfusion
