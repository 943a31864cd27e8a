#include "vtk/vtk_trial.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

#include "base/error.h"

namespace tetfusion {
namespace {

// Dies of its signals, silently and without a core file, whatever the parent has arranged.
void make_expendable() {
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGINT, SIGTERM, SIGPIPE}) {
    ::signal(number, SIG_DFL);
  }
  const rlimit none = {0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  const int nowhere = ::open("/dev/null", O_RDWR);
  if (nowhere < 0) return;
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
}

}  // namespace

void try_in_child(const std::string& path, const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child < 0) return;
  if (child == 0) {
    make_expendable();
    try {
      work();
    } catch (...) {  // NOLINT(bugprone-empty-catch): the parent will meet it again
    }
    ::_exit(0);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return;
  }
  if (!WIFSIGNALED(status)) return;
  const int number = WTERMSIG(status);
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

}  // namespace tetfusion
