// Keeps what is resident below a limit, where most of it lies in mapped files.
#pragma once

#include <cstdint>
#include <functional>

namespace tetfusion {

class ResidentLimit {
 public:
  // 0: there is no limit.
  explicit ResidentLimit(std::uint64_t bytes) : bytes_(bytes) {}

  // Calls let_go() if more than the limit is resident. To be called often: it looks only when many
  // pages have been touched since it looked last.
  void keep(const std::function<void()>& let_go);

 private:
  std::uint64_t bytes_;
  std::uint64_t faults_ = 0, resident_ = 0;          // when it looked last
  std::uint64_t of_fault_ = std::uint64_t{2} << 20;  // bytes that one brings, as far as is known
};

}  // namespace tetfusion
