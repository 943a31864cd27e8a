#include "io/files/fault_guard.h"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <mutex>

namespace tetfusion {

namespace {

constexpr std::uint64_t kNothingMissing = ~std::uint64_t{0};

struct Guard {
  std::atomic<bool> used{false};
  std::atomic<std::uintptr_t> begin{0};
  std::atomic<std::uintptr_t> end{0};  // 0 while the guard is being set up
  std::atomic<std::uint64_t> missing{kNothingMissing};
};
static_assert(std::atomic<std::uintptr_t>::is_always_lock_free, "read by a signal handler");

// The handler may run at any time, so it looks at nothing but this table, and takes no lock.
std::array<Guard, 1024> guards;
struct sigaction previous_action {};
std::uintptr_t page_bytes = 4096;

// Not ours: to whoever had the signal before. Without a handler of theirs, the instruction faults
// again and ends the process.
void pass_on(int signal, siginfo_t* info, void* context) {
  if ((previous_action.sa_flags & SA_SIGINFO) != 0) {
    previous_action.sa_sigaction(signal, info, context);
  } else if (previous_action.sa_handler != SIG_DFL && previous_action.sa_handler != SIG_IGN) {
    previous_action.sa_handler(signal);
  } else {
    ::sigaction(SIGBUS, &previous_action, nullptr);
  }
}

void on_fault(int signal, siginfo_t* info, void* context) {
  const auto address = reinterpret_cast<std::uintptr_t>(info->si_addr);
  for (Guard& guard : guards) {
    const std::uintptr_t begin = guard.begin.load();
    if (address < begin || address >= guard.end.load()) continue;
    const std::uintptr_t page = address / page_bytes * page_bytes;
    void* zeros = ::mmap(reinterpret_cast<void*>(page), page_bytes, PROT_READ,
                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
    if (zeros == MAP_FAILED) break;
    std::uint64_t none = kNothingMissing;
    guard.missing.compare_exchange_strong(none, page - begin);
    return;  // the instruction runs again and reads zeros
  }
  pass_on(signal, info, context);
}

void install_handler() {
  page_bytes = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  struct sigaction action {};
  action.sa_sigaction = on_fault;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  ::sigaction(SIGBUS, &action, &previous_action);
}

}  // namespace

int guard_mapping(const void* begin, std::size_t bytes) {
  static std::once_flag installed;
  std::call_once(installed, install_handler);
  for (std::size_t i = 0; i < guards.size(); ++i) {
    Guard& guard = guards[i];
    if (guard.used.exchange(true)) continue;
    guard.missing = kNothingMissing;
    guard.begin = reinterpret_cast<std::uintptr_t>(begin);
    guard.end = guard.begin + (bytes + page_bytes - 1) / page_bytes * page_bytes;
    return static_cast<int>(i);
  }
  return -1;
}

void unguard_mapping(int guard) {
  if (guard < 0) return;
  Guard& g = guards[static_cast<std::size_t>(guard)];
  g.end = 0;
  g.begin = 0;
  g.used = false;
}

std::optional<std::uint64_t> missing_page(int guard) {
  if (guard < 0) return std::nullopt;
  const std::uint64_t offset = guards[static_cast<std::size_t>(guard)].missing.load();
  if (offset == kNothingMissing) return std::nullopt;
  return offset;
}

}  // namespace tetfusion
