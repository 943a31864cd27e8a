// Faults in mapped files. When a page of a mapping cannot be read (the file was truncated by
// someone else, the disk fails) the kernel sends SIGBUS, which would end the process. Inside
// guarded mappings a page of zeros takes the place of the missing one, and the fault is remembered.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

namespace tetfusion {

// Guards [begin, begin + bytes), the whole of a mapping. Returns a number for the calls below; -1
// when too many mappings are guarded, and a fault is then what it always was. Installs a handler
// for SIGBUS on first use; faults elsewhere go to the handler that was there before. Thread-safe,
// like the calls below.
int guard_mapping(const void* begin, std::size_t bytes);
// Call before the mapping goes away.
void unguard_mapping(int guard);
// Offset of the page that was found missing first.
std::optional<std::uint64_t> missing_page(int guard);

}  // namespace tetfusion
