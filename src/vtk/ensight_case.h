// What an EnSight case says of its files and times, where VTK keeps that to itself.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tetfusion {

// Or numbers in binary form, of a file that a case names?
bool is_ensight_text(std::string_view file);

class EnSightCase {
 public:
  // Lines that make no sense are passed over: VTK's reader complains of them.
  explicit EnSightCase(const std::string& path);

  // Of all its sets, one after another, as precisely as they are written: VTK rounds them.
  std::vector<double> times() const;

  // Of all variables, constants of the case too, by their names there.
  const std::vector<std::string>& variables() const { return variables_; }

  // The files that are read for that time, in the order of the case, which begins with the
  // geometry. They may be missing.
  std::vector<std::string> files_at(double time) const;

  // What VTK's reader would not notice, or never come to an end with, in words; empty: nothing.
  std::string fault_of_times() const;

  // VTK's reader looks for the marks of steps in files until it finds them: without end where they
  // are missing. What is wrong with these, in words; empty: nothing. Throws Error(kIo).
  std::string fault_of_marks(double time) const;

  // VTK's reader takes so many lines of a geometry written as text as a count says, behind its end,
  // too. What is wrong with these, in words; empty: nothing. Throws Error(kIo).
  std::string fault_of_counts(double time) const;

  // Have the files of EnSight Gold that are text the lines that they say (ensight_gold.h)? What is
  // wrong, in words; empty: nothing. Throws Error(kIo).
  std::string fault_of_lines(double time) const;

 private:
  struct TimeSet {
    int id = 0;
    std::vector<double> times;
    std::vector<int> numbers;  // in the names of files, for each time
    int steps = 0, start = 0, increment = 1;

    // The last time that has come, as VTK compares them.
    std::size_t step_at(double time) const;
  };
  // A name may hold asterisks, which stand for the number of a step. It is told from the folder of
  // the case.
  struct NamedFile {
    std::string pattern;
    int time_set = 1;
    bool in_file_set = false;  // several steps are in one file
    std::string kind;          // "model", "scalar per node", ...
  };

  void take_line(const std::string& section, const std::string& key,
                 const std::vector<std::string>& words);
  void take_file(const std::string& section, const std::string& key,
                 std::vector<std::string> words);
  void take_time(const std::string& key, const std::vector<std::string>& words);
  const TimeSet* time_set(int id) const;
  std::vector<std::string> files_of(const NamedFile& file, double time) const;
  std::string in_folder(const std::string& name) const;

  std::string folder_;
  std::vector<NamedFile> files_;
  std::vector<std::string> variables_;
  std::vector<TimeSet> sets_;
  bool has_file_sets_ = false, is_gold_ = false;
};

}  // namespace tetfusion
