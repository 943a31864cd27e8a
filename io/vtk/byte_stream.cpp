#include "io/vtk/byte_stream.h"

#include <algorithm>

#include "base/blocks.h"
#include "io/vtk/decode.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kTextBlock = std::uint64_t{64} << 10;
constexpr std::uint64_t kTextBlocksPerRun = 16;

bool is_blank_byte(std::byte b) { return b <= std::byte{' '}; }

}  // namespace

ByteStream::ByteStream(const MappedFile& file, const Payload& payload)
    : file_(&file),
      text_(file.bytes().subspan(payload.begin, payload.end - payload.begin)),
      coding_(payload.coding),
      all_letters_(text_.size()) {
  if (coding_ == Coding::kBase64 && !payload.appended) find_blanks();
}

void ByteStream::find_blanks() {
  const std::uint64_t offset = static_cast<std::uint64_t>(text_.data() - file_->bytes().data());
  const bool small = text_.size() < kTextBlock;  // not worth a system call
  Vector<std::uint64_t> before(block_count(text_.size(), kTextBlock) + 1);
  before[0] = 0;
  for_each_block(text_.size(), kTextBlocksPerRun * kTextBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   for (std::size_t at = begin; at < end; at += kTextBlock) {
                     const std::size_t count = std::min<std::size_t>(kTextBlock, end - at);
                     const auto block = text_.subspan(at, count);
                     const auto blanks = std::count_if(block.begin(), block.end(), is_blank_byte);
                     before[at / kTextBlock + 1] = count - static_cast<std::uint64_t>(blanks);
                   }
                   if (!small) file_->dont_need(offset + begin, end - begin);
                 });
  if (!small) file_->dont_need_around(offset, text_.size());
  for (std::size_t b = 1; b < before.size(); ++b) before[b] += before[b - 1];
  all_letters_ = before.back();
  if (all_letters_ == text_.size()) return;
  letters_before_ = std::make_shared<const Vector<std::uint64_t>>(std::move(before));
}

std::uint64_t ByteStream::max_bytes() const {
  const std::uint64_t bytes = coding_ == Coding::kRaw ? text_.size() : letters() / 4 * 3;
  return bytes > first_ ? bytes - first_ : 0;
}

std::uint64_t ByteStream::place_of_letter(std::uint64_t letter) const {
  if (letters_before_ == nullptr) return letter;
  const Vector<std::uint64_t>& before = *letters_before_;
  const auto next = std::upper_bound(before.begin(), before.end(), letter);
  const auto block = static_cast<std::uint64_t>(next - before.begin()) - 1;
  return std::min<std::uint64_t>(block * kTextBlock, text_.size());
}

// All of them are there. `scratch` has room for them.
std::string_view ByteStream::read_letters(std::uint64_t first, std::uint64_t count,
                                          char* scratch) const {
  first += first_letter_;
  if (letters_before_ == nullptr) return as_text(text_.subspan(first, count));
  std::uint64_t at = place_of_letter(first);
  std::uint64_t skip = first - (*letters_before_)[at / kTextBlock];
  for (std::uint64_t made = 0; made < count; ++at) {
    if (is_blank_byte(text_[at])) continue;
    if (skip > 0) {
      --skip;
    } else {
      scratch[made++] = static_cast<char>(text_[at]);
    }
  }
  return {scratch, count};
}

const std::byte* ByteStream::view(std::uint64_t offset, std::uint64_t count,
                                  Vector<std::byte>* scratch) const {
  const std::uint64_t limit = max_bytes();
  if (offset > limit || count > limit - offset) return nullptr;
  if (coding_ == Coding::kRaw) return text_.data() + first_ + offset;
  const std::uint64_t begin = first_ + offset;
  const std::uint64_t first_group = begin / 3;
  const std::uint64_t groups = (begin + count + 2) / 3 - first_group;
  // The bytes, and where there are line breaks the letters without them.
  scratch->resize((letters_before_ == nullptr ? 3 : 7) * groups);
  char* const room = reinterpret_cast<char*>(scratch->data()) + 3 * groups;
  const std::string_view text = read_letters(4 * first_group, 4 * groups, room);
  const std::size_t made = decode_base64(text, scratch->data());
  const std::uint64_t skipped = begin - 3 * first_group;
  if (made == kBadBase64 || made < skipped + count) return nullptr;
  return scratch->data() + skipped;
}

ByteStream::FileRange ByteStream::place(std::uint64_t offset, std::uint64_t count) const {
  if (count == 0) return {};
  const auto start = static_cast<std::uint64_t>(text_.data() - file_->bytes().data());
  std::uint64_t begin = first_ + offset;
  std::uint64_t end = begin + count;
  if (coding_ == Coding::kBase64) {
    begin = place_of_letter(first_letter_ + begin / 3 * 4);
    end = place_of_letter(first_letter_ + (end + 2) / 3 * 4);
    if (letters_before_ != nullptr) end += kTextBlock;
  }
  return {start + begin, end - begin};
}

ByteStream ByteStream::after(std::uint64_t bytes, bool own_groups) const {
  ByteStream rest = *this;
  if (coding_ == Coding::kRaw || !own_groups) {
    rest.first_ += bytes;
  } else {
    rest.first_ = 0;
    rest.first_letter_ = std::min((bytes + 2) / 3 * 4, all_letters_);
  }
  return rest;
}

bool ByteStream::padded_within(std::uint64_t bytes) const {
  if (coding_ == Coding::kRaw) return false;
  // A header of its own is padded as its length asks for; data that follow it in the same group,
  // and end there, leave less padding.
  const std::uint64_t end = (bytes + 2) / 3 * 4;
  const std::uint64_t padding = (3 - bytes % 3) % 3;
  if (padding == 0 || end > letters()) return false;
  char letter = 0;
  return read_letters(end - padding, 1, &letter) == "=";
}

}  // namespace tetfusion
