// Reading that ends in a message which can be believed.
#pragma once

#include <new>
#include <stdexcept>

#include "base/error.h"
#include "io/files/mapped_file.h"

namespace tetfusion {

// Calls f(), which reads `file`. A file that was shortened under us reads as zeros from there on:
// that is what is wrong, whatever follows from it. No size in the file makes an allocation fail
// before it was compared with the file's length; what remains is a mesh that is too large for this
// machine.
template <class F>
void read_guarded(const MappedFile& file, F f) {
  const auto fail = [&] {
    throw Error(ErrorCode::kMemory, file.path() + ": there is not enough memory to read the mesh");
  };
  try {
    f();
  } catch (const Error&) {
    file.check();
    throw;
  } catch (const std::bad_alloc&) {
    fail();
  } catch (const std::length_error&) {
    fail();
  }
  file.check();
}

}  // namespace tetfusion
