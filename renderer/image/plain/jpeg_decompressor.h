#pragma once

#include <csetjmp>
#include <cstdio>
// After <cstdio>, whose FILE it names.
#include <jpeglib.h>

namespace tessera {

/// libjpeg's errors leave by longjmp() to `place`, so no frame between may own anything.
struct JpegErrors {
  jpeg_error_mgr base;
  std::jmp_buf place;

  /// Makes `info`, not yet created, report here; what is only a warning is counted.
  void attach(jpeg_decompress_struct& info) {
    info.err = jpeg_std_error(&base);
    base.error_exit = [](j_common_ptr of) {
      std::longjmp(reinterpret_cast<JpegErrors*>(of->err)->place, 1);
    };
    base.emit_message = [](j_common_ptr of, int level) {
      if (level < 0) ++of->err->num_warnings;
    };
  }
};

}  // namespace tessera
