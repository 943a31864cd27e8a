#include <cerrno>
#include <stdexcept>
#include <string>
#include <vector>

#include "cli/command_line.h"
#include "fuzz/targets.h"
#include "io/files/file_system.h"

namespace tetfusion::fuzz {

namespace {

// Lets nobody open, make, name or remove a file: jobs end where they would begin, whatever their
// options name.
class ClosedFileSystem final : public FileSystem {
 public:
  ClosedFileSystem() : before_(replace_file_system(this)) {}
  ~ClosedFileSystem() override { replace_file_system(before_); }
  ClosedFileSystem(const ClosedFileSystem&) = delete;
  ClosedFileSystem& operator=(const ClosedFileSystem&) = delete;

  int openat(int, const char*, int, mode_t) override { return refuse(); }
  int duplicate(int) override { return refuse(); }
  ssize_t read(int, void*, std::size_t) override { return refuse(); }
  ssize_t write(int, const void*, std::size_t) override { return refuse(); }
  int renameat(int, const char*, int, const char*) override { return refuse(); }
  int link_descriptor(int, const char*) override { return refuse(); }
  int unlinkat(int, const char*, int) override { return refuse(); }
  int mkdir(const char*, mode_t) override { return refuse(); }

 private:
  static int refuse() {
    errno = EACCES;
    return -1;
  }
  FileSystem* before_;
};

}  // namespace

void run_command(Input input) {
  std::vector<std::string> arguments{"tetfusion"};
  for (const std::uint8_t byte : input) {
    if (arguments.size() == 1) arguments.emplace_back();
    if (byte == '\n') {
      arguments.emplace_back();
    } else if (byte != 0) {  // which no argument can hold
      arguments.back() += static_cast<char>(byte);
    }
  }
  std::vector<const char*> argv;
  for (const std::string& a : arguments) argv.push_back(a.c_str());
  const ClosedFileSystem nothing;
  const int code = run_command_line(static_cast<int>(argv.size()), argv.data());
  // Nothing was done, so only help and refusals are left.
  if (code != 0 && (code < 2 || code > 5))
    throw std::logic_error("exit code " + std::to_string(code));
}

}  // namespace tetfusion::fuzz
