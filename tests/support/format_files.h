// What the tests of other programs' formats share: files made byte by byte, read whole.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "io/source/mesh_source.h"
#include "mesh/geometry.h"
#include "support/temp_dir.h"

namespace tetfusion::testing {

// Bytes of a binary file, of either byte order.
class Bytes {
 public:
  explicit Bytes(bool swapped = false) : swapped_(swapped) {}
  template <class T>
  Bytes& put(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (swapped_) std::reverse(bytes, bytes + sizeof(T));
    text_.append(bytes, sizeof(T));
    return *this;
  }
  template <class T>
  Bytes& put_all(const std::vector<T>& values) {
    for (const T value : values) put(value);
    return *this;
  }
  Bytes& text(std::string_view text) {
    text_ += text;
    return *this;
  }
  std::size_t size() const { return text_.size(); }
  const std::string& str() const { return text_; }

 private:
  bool swapped_;
  std::string text_;
};

// The text with the first `from`, which it must have, made `to`.
std::string replaced(std::string text, std::string_view from, std::string_view to);

// A mesh and all its arrays as text: equal for equal meshes alone.
std::string dump(MeshSource* source);

class FormatTest : public ::testing::Test {
 protected:
  // Writes the files, by their names, and opens the first one named.
  std::unique_ptr<MeshSource> open(const std::string& name, const std::string& bytes,
                                   const OpenOptions& options = {});
  // The same after a look whether it is the same mesh, or none, whole and in windows.
  std::unique_ptr<MeshSource> open_and_compare(const std::string& name, const std::string& bytes,
                                               const OpenOptions& options = {});
  void write(const std::string& name, const std::string& bytes);
  // Reads it all; the error must have that code, name the file and hold `words`.
  void expect_error(const std::string& name, const std::string& bytes, const std::string& words,
                    int code = 3, const OpenOptions& options = {});
  // The dump, or nothing after an Error that names a file of the test; anything else fails it.
  std::string read_or_refuse(const std::string& name, const std::string& bytes);
  // The file cut at every byte: an error, or the whole mesh where the rest says nothing.
  void expect_no_half_mesh(const std::string& name, const std::string& bytes);
  // Each byte in turn is another one: an error or some mesh.
  void expect_no_crash(const std::string& name, const std::string& bytes);
  // Points and tetrahedra of the sample that the tests write in each format.
  static void expect_sample(const Geometry& mesh);
  // What convert writes of a mesh, read again.
  void convert(MeshSource* source, const std::string& name);

  TempDir dir_ = TempDir::in_memory();
};

}  // namespace tetfusion::testing
