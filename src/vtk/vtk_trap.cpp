#include "vtk/vtk_trap.h"

#include <sys/mman.h>
#include <unistd.h>
#include <vtkObjectFactory.h>

#include <array>
#include <cstdio>
#include <string_view>

#include "base/error.h"

namespace tetfusion {
namespace {

// "ERROR: In vtkFoo.cxx, line 1\nvtkFoo (0x55d0): What is wrong\n\n" is "What is wrong".
std::string tidy(std::string_view text) {
  const std::size_t object = text.find("): ");
  if (object != std::string_view::npos) text.remove_prefix(object + 3);
  std::string words;
  for (const char c : text) {
    const bool blank = c == '\n' || c == '\r' || c == '\t' || c == ' ';
    if (!blank) {
      words += c;
    } else if (!words.empty() && words.back() != ' ') {
      words += ' ';
    }
  }
  while (!words.empty() && words.back() == ' ') words.pop_back();
  return words.empty() ? "an error without a message" : words;
}

}  // namespace

vtkStandardNewMacro(MessageTrap);

void MessageTrap::DisplayErrorText(const char* text) {
  if (error_.empty() && text != nullptr) error_ = tidy(text);
}

void MessageTrap::DisplayWarningText(const char* text) {
  if (text != nullptr) warnings_.insert(tidy(text));
}

void MessageTrap::DisplayGenericWarningText(const char* text) {
  if (text != nullptr) generic_warnings_.insert(tidy(text));
}

TrapScope::TrapScope()
    : before_(vtkOutputWindow::GetInstance()),
      verbosity_before_(vtkLogger::GetCurrentVerbosityCutoff()) {
  trap_->SetDisplayMode(vtkOutputWindow::NEVER);
  vtkOutputWindow::SetInstance(trap_);
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

TrapScope::~TrapScope() {
  vtkOutputWindow::SetInstance(before_);
  vtkLogger::SetStderrVerbosity(verbosity_before_);
}

void TrapScope::check(const std::string& path) const {
  if (trap_->error().empty()) return;
  throw Error(ErrorCode::kBadInput, path + ": VTK cannot read it: " + trap_->error());
}

StandardErrorCaught::StandardErrorCaught() {
  std::fflush(stderr);
  before_ = ::dup(STDERR_FILENO);
  caught_ = ::memfd_create("standard error", MFD_CLOEXEC);
  if (before_ >= 0 && caught_ >= 0) ::dup2(caught_, STDERR_FILENO);
}

std::string StandardErrorCaught::text() const {
  std::fflush(stderr);
  std::array<char, 200> words{};
  const ssize_t size = caught_ >= 0 ? ::pread(caught_, words.data(), words.size(), 0) : 0;
  return size > 0 ? tidy({words.data(), static_cast<std::size_t>(size)}) : "";
}

StandardErrorCaught::~StandardErrorCaught() {
  std::fflush(stderr);
  if (before_ >= 0) {
    ::dup2(before_, STDERR_FILENO);
    ::close(before_);
  }
  if (caught_ >= 0) ::close(caught_);
}

}  // namespace tetfusion
