// How a .vtu holds the values of its arrays.
#pragma once

namespace tetfusion {

// Appended to the markup: as they are, or in compressed blocks; or within it: base64, text.
enum class Encoding { kRaw, kZlib, kLz4, kInline, kAscii };

}  // namespace tetfusion
