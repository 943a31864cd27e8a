// Changes a file of VTK's so that most of it is still one: an attribute's value, the data between
// two tags (base64 is taken apart and put together again), a whole element; or any bytes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tetfusion::fuzz {

// Changes at most `max_size` bytes in place, of which `size` are in use; returns how many are then.
using MutateBytes = std::size_t (*)(std::uint8_t* data, std::size_t size, std::size_t max_size);

// As LLVMFuzzerCustomMutator(). `any` changes bytes without knowing what they are.
std::size_t mutate_xml(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed,
                       MutateBytes any);

}  // namespace tetfusion::fuzz
