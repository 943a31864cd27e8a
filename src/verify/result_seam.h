// The seam between a result that is written, but has no name yet, and its verification: tests
// damage it there.
#pragma once

#include <string>

namespace tetfusion {

// This class leaves it as it is; tests derive from it.
class ResultSeam {
 public:
  virtual ~ResultSeam() = default;

  // `path` is where the result can be read, and written; of a .pvtu a file that names its pieces.
  virtual void written(const std::string& path);
};

ResultSeam& result_seam();

// For tests: puts another one in its place and returns the one before; nullptr means the usual one.
// Not while work is under way.
ResultSeam* replace_result_seam(ResultSeam* other);

}  // namespace tetfusion
