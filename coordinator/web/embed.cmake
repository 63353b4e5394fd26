# cmake -DFOLDER=page -DOUTPUT=web_pages.cpp -P embed.cmake: the page's files as constants, and the
# function of web_pages.h that finds them.
set(type_html "text/html; charset=utf-8")
set(type_css "text/css; charset=utf-8")
set(type_js "text/javascript; charset=utf-8")
set(type_svg "image/svg+xml")
file(GLOB files "${FOLDER}/*")
list(SORT files)
set(cases "")
set(constants "")
set(index 0)
foreach(path IN LISTS files)
  get_filename_component(name "${path}" NAME)
  get_filename_component(extension "${path}" LAST_EXT)
  string(SUBSTRING "${extension}" 1 -1 extension)
  if(NOT DEFINED type_${extension})
    message(FATAL_ERROR "${path}: of no type that is known here; expected html, css, js or svg")
  endif()
  file(READ "${path}" bytes HEX)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  string(APPEND constants "constexpr unsigned char kFile${index}[] = {${bytes}};\n")
  if(name STREQUAL "index.html")
    set(name "")
  endif()
  string(APPEND cases "  if (path == \"/${name}\") return WebPage{\"${type_${extension}}\", text(kFile${index})};\n")
  math(EXPR index "${index} + 1")
endforeach()
file(WRITE "${OUTPUT}" "#include \"coordinator/web/web_pages.h\"

namespace tessera {
namespace {

template <size_t N>
std::string_view text(const unsigned char (&bytes)[N]) {
  return {reinterpret_cast<const char*>(bytes), N};
}

${constants}
}  // namespace

std::optional<WebPage> find_web_page(std::string_view path) {
${cases}  return std::nullopt;
}

}  // namespace tessera
")
