// One target for libFuzzer: FUZZ_TARGET is its name. FUZZ_XML: its inputs are changed as XML is.
#include "fuzz/targets.h"
#ifdef FUZZ_XML
#include "fuzz/mutate_xml.h"
#endif

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const tetfusion::fuzz::Target* const target = tetfusion::fuzz::find_target(FUZZ_TARGET);
  target->run({data, size});
  return 0;
}

#ifdef FUZZ_XML
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  return tetfusion::fuzz::mutate_xml(data, size, max_size, seed, LLVMFuzzerMutate);
}
#endif
