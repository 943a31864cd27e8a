// What VTK complains of, as an error of ours, and nothing printed.
#pragma once

#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <set>
#include <string>

namespace tetfusion {

// Keeps VTK's first error message, and its warnings, instead of printing them.
class MessageTrap : public vtkOutputWindow {
 public:
  static MessageTrap* New();

  void DisplayText(const char*) override {}
  void DisplayWarningText(const char* text) override;
  void DisplayGenericWarningText(const char* text) override;
  void DisplayDebugText(const char*) override {}
  void DisplayErrorText(const char* text) override;
  const std::string& error() const { return error_; }
  const std::set<std::string>& warnings() const { return warnings_; }
  const std::set<std::string>& generic_warnings() const { return generic_warnings_; }

 private:
  std::string error_;
  std::set<std::string> warnings_, generic_warnings_;
};

// Puts a trap in the place of VTK's message window for its life time, and keeps VTK's log quiet,
// which would print the same messages. Not to be used in two threads at once.
class TrapScope {
 public:
  TrapScope();
  ~TrapScope();
  TrapScope(const TrapScope&) = delete;
  TrapScope& operator=(const TrapScope&) = delete;

  // Throws Error(kBadInput) with VTK's first error since the beginning.
  void check(const std::string& path) const;

  // VTK's own words, each of them once.
  const std::set<std::string>& warnings() const { return trap_->warnings(); }
  // Those that no object of VTK's says of itself.
  const std::set<std::string>& generic_warnings() const { return trap_->generic_warnings(); }

 private:
  vtkSmartPointer<vtkOutputWindow> before_;
  vtkLogger::Verbosity verbosity_before_;
  vtkNew<MessageTrap> trap_;
};

// What libraries print on standard error during its life time is kept, and so is what other threads
// print.
class StandardErrorCaught {
 public:
  StandardErrorCaught();
  ~StandardErrorCaught();
  StandardErrorCaught(const StandardErrorCaught&) = delete;
  StandardErrorCaught& operator=(const StandardErrorCaught&) = delete;

  // The beginning of it, in one line.
  std::string text() const;

 private:
  int before_ = -1, caught_ = -1;
};

}  // namespace tetfusion
