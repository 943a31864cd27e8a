#include "support/temp_dir.h"

#include <stdlib.h>

#include <stdexcept>

namespace tetfusion::testing {

TempDir::TempDir() {
  std::string name = (std::filesystem::temp_directory_path() / "tetfusion-test-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("cannot make " + name);
  path_ = name;
}

TempDir::~TempDir() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace tetfusion::testing
