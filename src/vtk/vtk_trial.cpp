#include "vtk/vtk_trial.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"

namespace tetfusion {
namespace {

constexpr std::array kInterrupts{SIGHUP, SIGINT, SIGTERM};

// Dies of its signals, silently and without a core file, whatever the parent has arranged; but an
// interrupt that is ignored, as under nohup, still is.
void make_expendable() {
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGPIPE}) {
    ::signal(number, SIG_DFL);
  }
  for (const int number : kInterrupts) {
    if (::signal(number, SIG_DFL) == SIG_IGN) ::signal(number, SIG_IGN);
  }
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // some damaged files hold VTK for ever
  const rlimit none = {0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  const int nowhere = ::open("/dev/null", O_RDWR);
  if (nowhere < 0) return;
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
}

// Some libraries end the process where they cannot go on; this makes that known, and spares what a
// process that ends tidies up, which is the parent's.
constexpr int kGaveUp = 3;
void give_up() { ::_exit(kGaveUp); }

// How the child tells the parent of its error: the code in one byte, then the message.
void send(int pipe, const Error& error) {
  constexpr std::size_t kLongest = 4000;  // a pipe takes it at once
  std::string text(1, static_cast<char>(error.code()));
  text += std::string_view(error.what()).substr(0, kLongest);
  [[maybe_unused]] const ssize_t sent = ::write(pipe, text.data(), text.size());
}

[[noreturn]] void work_in_child(int pipe, const std::string& path,
                                const std::function<void()>& work) noexcept {
  make_expendable();
  std::atexit(give_up);
  try {
    work();
  } catch (const InvalidMesh&) {  // NOLINT(bugprone-empty-catch): the parent will meet it again
  } catch (...) {
    send(pipe, caught_error(path));
  }
  ::_exit(0);
}

// What a child may write to beside what it has from its parent, and whether it may go on.
class Watch {
 public:
  Watch(const std::string& path, const OpenOptions& options)
      : path_(path), options_(options), inherited_(written_memory(::getpid())) {
    const std::uint64_t limit = memory_limit();
    spare_ = std::min(available_memory(), limit - std::min(inherited_, limit));
    // VTK holds more while it reads than the plan of a run counts, which is of what stays.
    granted_ = options.memory > 0 && options.memory < spare_ / 2 ? 2 * options.memory : spare_;
  }

  void check(pid_t child) const {
    if (options_.cancelled != nullptr && options_.cancelled->load(std::memory_order_relaxed)) {
      throw_interrupted();
    }
    const std::uint64_t bound = std::max(granted_, kAlwaysFree);
    if (written_memory(child) <= inherited_ + bound) return;
    const std::string advice =
        granted_ < spare_ ? ": give --memory " + format_memory(bound) + " or more"
                          : ", and that is what this machine has to spare: end other programs, or "
                            "take a larger one";
    throw Error(ErrorCode::kMemory, path_ + ": VTK takes more than " + format_bytes(bound) +
                                        " of memory to read it" + advice +
                                        "; or the file is damaged, and a count in it is wrong");
  }

  [[noreturn]] static void throw_interrupted() {
    throw Error(ErrorCode::kInterrupted, "interrupted; nothing was written");
  }

 private:
  // So that a run with too small a --memory is told how much it needs, where the file is small.
  static constexpr std::uint64_t kAlwaysFree = std::uint64_t{256} << 20;

  const std::string& path_;
  const OpenOptions& options_;
  std::uint64_t inherited_, spare_ = 0, granted_ = 0;
};

class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0) ends_ = {-1, -1};
  }
  ~Pipe() {
    close_entry();
    if (ends_[0] >= 0) ::close(ends_[0]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  bool is_open() const { return ends_[0] >= 0; }
  int exit() const { return ends_[0]; }
  int entry() const { return ends_[1]; }
  void close_entry() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  std::array<int, 2> ends_{};
};

// Ended, if it has not ended by itself, with its object.
class Child {
 public:
  explicit Child(pid_t id) : id_(id) {}
  ~Child() {
    if (id_ <= 0) return;
    ::kill(id_, SIGKILL);
    wait();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t id() const { return id_; }
  // As waitpid() says it; 0 where nobody knows.
  int wait() {
    int status = 0;
    while (::waitpid(id_, &status, 0) < 0) {
      if (errno == EINTR) continue;
      status = 0;
      break;
    }
    id_ = 0;
    return status;
  }

 private:
  pid_t id_;
};

// All that the child sent, when it has ended. Throws what watch.check() throws.
std::string receive(int pipe, const Child& child, const Watch& watch) {
  constexpr int kMillisecondsBetweenLooks = 20;  // in which a processor writes to about 100 MiB
  std::string text;
  std::array<char, 4096> part{};
  for (;;) {
    watch.check(child.id());
    pollfd waiting{pipe, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, kMillisecondsBetweenLooks);
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    const ssize_t got = ::read(pipe, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    text.append(part.data(), static_cast<std::size_t>(got));
  }
}

[[noreturn]] void throw_killed(const std::string& path, int number) {
  if (std::find(kInterrupts.begin(), kInterrupts.end(), number) != kInterrupts.end()) {
    Watch::throw_interrupted();
  }
  if (number == SIGKILL) {
    throw Error(ErrorCode::kMemory,
                path + ": the system ended VTK while it read the file: there is not enough memory");
  }
  throw Error(ErrorCode::kBadInput, path + ": VTK crashes when it reads this file (signal " +
                                        std::to_string(number) + "): the file is damaged");
}

}  // namespace

Error caught_error(const std::string& path) {
  const auto damaged = [&](const std::string& what) {
    return Error(ErrorCode::kBadInput, path + ": " + what + ": the file is damaged");
  };
  const std::string too_many = "a count in it is larger than any memory, or less than nothing";
  try {
    throw;
  } catch (const Error& error) {
    return error;
  } catch (const std::bad_array_new_length&) {
    return damaged(too_many);
  } catch (const std::length_error&) {
    return damaged(too_many);
  } catch (const std::bad_alloc&) {
    return {ErrorCode::kMemory,
            path +
                ": there is not enough memory to read it with VTK, which holds all of it at once; "
                "or the file is damaged, and a count in it is wrong"};
  } catch (const std::exception& error) {
    return damaged(std::string("VTK gives up when it reads it (") + error.what() + ")");
  } catch (...) {
    return damaged("VTK gives up when it reads it");
  }
}

void try_in_child(const std::string& path, const OpenOptions& options,
                  const std::function<void()>& work) {
  const Watch watch(path, options);
  Pipe pipe;
  if (!pipe.is_open()) return;
  Child child(::fork());
  if (child.id() < 0) return;
  if (child.id() == 0) work_in_child(pipe.entry(), path, work);
  pipe.close_entry();
  const std::string told = receive(pipe.exit(), child, watch);
  const int status = child.wait();
  if (WIFSIGNALED(status)) throw_killed(path, WTERMSIG(status));
  if (!told.empty())
    throw Error(static_cast<ErrorCode>(static_cast<unsigned char>(told[0])), told.substr(1));
  if (WIFEXITED(status) && WEXITSTATUS(status) == kGaveUp) {
    throw Error(ErrorCode::kBadInput,
                path + ": VTK cannot go on when it reads this file: the file is damaged");
  }
}

}  // namespace tetfusion
