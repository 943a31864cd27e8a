#include "vtk/vtk_trial.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>

#include "base/error.h"

namespace tetfusion {
namespace {

// Dies of its signals, silently and without a core file, whatever the parent has arranged.
void make_expendable() {
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGINT, SIGTERM, SIGPIPE}) {
    ::signal(number, SIG_DFL);
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

// All that the child sent, when it has ended.
std::string receive(int pipe) {
  std::string text;
  std::array<char, 4096> part{};
  for (;;) {
    const ssize_t got = ::read(pipe, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    text.append(part.data(), static_cast<std::size_t>(got));
  }
}

[[noreturn]] void throw_killed(const std::string& path, int number) {
  if (number == SIGINT || number == SIGTERM) {
    throw Error(ErrorCode::kInterrupted, "interrupted; nothing was written");
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

void try_in_child(const std::string& path, const std::function<void()>& work) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return;
  const pid_t child = ::fork();
  if (child == 0) work_in_child(ends[1], path, work);
  ::close(ends[1]);
  const std::string told = child > 0 ? receive(ends[0]) : "";
  ::close(ends[0]);
  if (child < 0) return;
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return;
  }
  if (WIFSIGNALED(status)) throw_killed(path, WTERMSIG(status));
  if (!told.empty())
    throw Error(static_cast<ErrorCode>(static_cast<unsigned char>(told[0])), told.substr(1));
  if (WIFEXITED(status) && WEXITSTATUS(status) == kGaveUp) {
    throw Error(ErrorCode::kBadInput,
                path + ": VTK cannot go on when it reads this file: the file is damaged");
  }
}

}  // namespace tetfusion
