#include "scenes/formats/x3d/geometry/stroke_font.h"

#include <algorithm>
#include <array>

namespace tessera {
namespace {

constexpr double kGap = 2;  // between glyphs
constexpr int kBaseline = 3;

/// From '!' on. Each pair of digits is a point: x, and y in hexadecimal with the baseline at 3,
/// small letters up to 8 and capitals up to b. A space begins a new line.
constexpr std::array<std::string_view, 94> kGlyphs{
    "0b06 03",                           // !
    "0b09 2b29",                         // "
    "141a 444a 0656 0858",               // #
    "6a5b1b0a0817576664531304 3c32",     // $
    "036b 0a1b2a190a 4455645344",        // %
    "63191a2b3a390504134366",            // &
    "0b09",                              // '
    "2b090523",                          // (
    "0b292503",                          // )
    "363a 1957 1759",                    // *
    "0666 3339",                         // +
    "1302",                              // ,
    "0646",                              // -
    "03",                                // .
    "035b",                              // /
    "1353646a5b1b0a0413",                // 0
    "193b33 1353",                       // 1
    "0a1b5b6a680363",                    // 2
    "0a1b5b6a685727 576664531304",       // 3
    "4b0565 4b43",                       // 4
    "6b0b07576664531304",                // 5
    "5b2b0904135364665707",              // 6
    "0b6b23",                            // 7
    "17080a1b5b6a68571706041353646657",  // 8
    "6717080a1b5b6a654313",              // 9
    "04 08",                             // :
    "1302 18",                           // ;
    "490643",                            // <
    "0545 0747",                         // =
    "094603",                            // >
    "0a1b4b5a583635 33",                 // ?
    "5313040a1b5b6a66363969",            // @
    "033b63 1656",                       // A
    "030b4b5a584707 4766645303",         // B
    "6a5b1b0a04135364",                  // C
    "030b4b69654303",                    // D
    "6b0b0363 0747",                     // E
    "6b0b03 0747",                       // F
    "6a5b1b0a041353646737",              // G
    "030b 636b 0767",                    // H
    "0343 2b23 0b4b",                    // I
    "4b44331304",                        // J
    "030b 6b06 2763",                    // K
    "0b0363",                            // L
    "030b376b63",                        // M
    "030b636b",                          // N
    "1353646a5b1b0a0413",                // O
    "030b5b6a685707",                    // P
    "1353646a5b1b0a0413 3563",           // Q
    "030b5b6a685707 3763",               // R
    "6a5b1b0a0817576664531304",          // S
    "0b6b 3b33",                         // T
    "0b041353646b",                      // U
    "0b336b",                            // V
    "0b1338536b",                        // W
    "036b 0b63",                         // X
    "0b376b 3733",                       // Y
    "0b6b0363",                          // Z
    "2b0b0323",                          // [
    "0b53",                              // backslash
    "0b2b2303",                          // ]
    "092b49",                            // ^
    "0262",                              // _
    "0b19",                              // `
    "0718485753 56160504134354",         // a
    "0b03 0413435457481807",             // b
    "5748180704134354",                  // c
    "5b53 5443130407184857",             // d
    "06565748180704134354",              // e
    "4b3b2a23 0848",                     // f
    "5851401001 5443130407184857",       // g
    "0b03 0718485753",                   // h
    "0803 0a",                           // i
    "28211000 2a",                       // j
    "0b03 4805 1643",                    // k
    "0b0413",                            // l
    "0803 0718283733 3748586763",        // m
    "0803 0718485753",                   // n
    "134354574818070413",                // o
    "0800 0413435457481807",             // p
    "5850 5443130407184857",             // q
    "0803 07183847",                     // r
    "57481807164554431304",              // s
    "2b243343 0848",                     // t
    "0804134354 5853",                   // u
    "082348",                            // v
    "0813375368",                        // w
    "0853 0358",                         // x
    "0823 5810",                         // y
    "08580353",                          // z
    "3b2b1a180716142333",                // {
    "0b00",                              // |
    "0b1b2a283726241303",                // }
    "061727465667",                      // ~
};

int digit(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

}  // namespace

StrokeGlyph stroke_glyph(unsigned char character) {
  StrokeGlyph glyph;
  if (character == ' ') return glyph;
  const bool known = character > ' ' && character <= '~';
  const std::string_view code = kGlyphs[(known ? character : '?') - '!'];
  double width = 0;
  glyph.strokes.emplace_back();
  for (size_t at = 0; at + 1 < code.size(); at += 2) {
    if (code[at] == ' ') {
      glyph.strokes.emplace_back();
      ++at;
    }
    const double x = digit(code[at]), y = digit(code[at + 1]) - kBaseline;
    glyph.strokes.back().points.push_back({x, y});
    width = std::max(width, x);
  }
  glyph.advance = width + kGap;
  return glyph;
}

}  // namespace tessera
