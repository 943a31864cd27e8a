#include "io/formats/counted_rows.h"

#include <algorithm>

#include "base/numbers.h"

namespace tetfusion {

void fail_of_rows(const FormatFile& file, const std::string& what, std::string_view text,
                  char comment, const TextTokens& found, std::uint64_t rows,
                  std::uint64_t columns) {
  const std::string message = what + "expected " + format_count(rows, "row") + " of " +
                              format_count(columns, "number") + ", found " +
                              format_count(found.size(), "number");
  for (std::string_view left = text; !left.empty();) {
    const std::string_view line = left.substr(0, left.find('\n'));
    TokenCursor cursor(line, comment);
    const std::string_view first = cursor.next();
    std::uint64_t tokens = first.empty() ? 0 : 1;
    while (tokens > 0 && !cursor.next().empty()) ++tokens;
    if (tokens > 0 && tokens != columns) {
      file.fail_in_line(first.data(), message + ", " + std::to_string(tokens) + " in this line");
    }
    left.remove_prefix(std::min(line.size() + 1, left.size()));
  }
  const std::string_view surplus = found[rows * columns];
  file.fail_in_line(surplus.empty() ? text.data() + text.size() : surplus.data(), message);
}

}  // namespace tetfusion
