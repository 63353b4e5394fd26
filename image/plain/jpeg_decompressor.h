#pragma once

#include <csetjmp>
#include <cstdio>
// After <cstdio>, whose FILE it names.
#include <jpeglib.h>

namespace tessera {

/// libjpeg's decompressor, destroyed with this. Its errors leave by longjmp() to `place`, set by
/// who calls libjpeg; no frame from there on may own anything.
struct JpegDecompressor {
  jpeg_decompress_struct info{};
  jpeg_error_mgr errors{};
  std::jmp_buf place{};
  char damage[JMSG_LENGTH_MAX] = {};  ///< the first warning: what is wrong with the file's data

  /// `info` is still to be created, which may fail; what is only a warning is counted.
  JpegDecompressor() {
    info.err = jpeg_std_error(&errors);
    info.client_data = this;
    errors.error_exit = [](j_common_ptr of) {
      std::longjmp(static_cast<JpegDecompressor*>(of->client_data)->place, 1);
    };
    errors.emit_message = [](j_common_ptr of, int level) {
      if (level >= 0) return;
      auto& jpeg = *static_cast<JpegDecompressor*>(of->client_data);
      if (jpeg.damage[0] == 0) of->err->format_message(of, jpeg.damage);
      ++of->err->num_warnings;
    };
  }
  JpegDecompressor(const JpegDecompressor&) = delete;
  JpegDecompressor& operator=(const JpegDecompressor&) = delete;
  ~JpegDecompressor() { jpeg_destroy_decompress(&info); }
};

}  // namespace tessera
