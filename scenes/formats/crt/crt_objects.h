#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/formats/crt/crt_attributes.h"

namespace tessera {

bool is_crt_object(std::string_view name);
std::vector<std::string> crt_object_names();
/// The object of that name, which must be known, or CrtFailed where an attribute was wrong.
CrtValue make_crt_object(std::string_view name, CrtAttributes& attributes, CrtHeap& heap);

// By kind; each file has its own.
CrtValue make_crt_camera(CrtAttributes& attributes, CrtHeap& heap);
CrtValue make_crt_light(std::string_view name, CrtAttributes& attributes, CrtHeap& heap);
CrtValue make_crt_shape(std::string_view name, CrtAttributes& attributes, CrtHeap& heap);

void put(const Vec3& from, v1::Vec3* to);
void put(const Color& from, v1::Color* to);

}  // namespace tessera
