// Rows of numbers in a text, of which a file says how many there are.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "io/formats/format_file.h"
#include "io/formats/text_tokens.h"

namespace tetfusion {

// Throws for a part of the file that does not have `rows` rows of `columns` numbers, but those of
// `found`: "Triangles: expected 12 rows of 4 numbers, found 47 numbers, 3 in this line", of the
// first line that is longer or shorter than a row, or of the end. `what` begins the message.
[[noreturn]] void fail_of_rows(const FormatFile& file, const std::string& what,
                               std::string_view text, char comment, const TextTokens& found,
                               std::uint64_t rows, std::uint64_t columns);

}  // namespace tetfusion
