// `tessera._core.Tracer`: ray queries for tessera/rays.py, which shapes the arrays.
#include <fmt/format.h>

#include <pybind11/stl.h>

#include <cstring>

#include "base/digest.h"
#include "base/parallel.h"
#include "front/load_frame.h"
#include "front/render_options.h"
#include "python/array.h"
#include "python/array_source.h"
#include "python/bindings.h"
#include "python/errors.h"
#include "python/gil.h"
#include "python/interruptible.h"
#include "python/scene_values.h"
#include "query/ray_queries.h"

namespace py = pybind11;

namespace tessera {
namespace {

[[noreturn]] void fail_array(const char* name, const std::string& found, const char* expected) {
  throw python_error("UsageError", fmt::format("{}: {}; expected {}", name, found, expected));
}

/// "elements of format 'd', shape (8, 3)".
std::string told(const py::buffer_info& view) {
  return fmt::format("elements of format '{}', shape {}", view.format, shape_text(view.shape));
}

/// A view of the caller's memory, kept as long as this lives.
py::buffer_info view_of(const char* name, const py::object& object, bool writable = false) {
  if (!PyObject_CheckBuffer(object.ptr()))
    fail_array(name, with_article(Py_TYPE(object.ptr())->tp_name), "an array");
  return py::reinterpret_borrow<py::buffer>(object).request(writable);
}

/// Rows of three numbers.
class VectorArray {
 public:
  VectorArray(const char* name, const py::object& object) : view_(view_of(name, object)) {
    const bool is_single = view_.format == "f";
    if ((!is_single && view_.format != "d") || view_.ndim != 2 || view_.shape[1] != 3)
      fail_array(name, told(view_), "rows of three float64 or float32");
    rows_ = {view_.ptr, view_.strides[0], view_.strides[1], is_single};
  }
  size_t count() const { return static_cast<size_t>(view_.shape[0]); }
  const VectorRows& rows() const { return rows_; }
  std::string found() const { return told(view_); }

 private:
  py::buffer_info view_;
  VectorRows rows_;
};

/// An array in C order of as many `T`s as are wanted, or null for None.
template <typename T>
class PlainArray {
 public:
  PlainArray(const char* name, const py::object& object, size_t count, bool writable = true) {
    if (object.is_none()) return;
    view_ = view_of(name, object, writable);
    if (view_.format.size() != 1 || view_.itemsize != sizeof(T) ||
        static_cast<size_t>(view_.size) != count || PyBuffer_IsContiguous(view_.view(), 'C') == 0 ||
        (view_.format[0] == 'd' || view_.format[0] == 'f') != std::is_floating_point_v<T>)
      fail_array(name, told(view_), "one in C order with an entry for each ray");
    data_ = static_cast<T*>(view_.ptr);
  }
  T* data() const { return data_; }

 private:
  py::buffer_info view_;
  T* data_ = nullptr;
};

/// One number for each ray, or one for all.
class NumberArray {
 public:
  NumberArray(const char* name, const py::object& object, size_t count) {
    if (py::isinstance<py::float_>(object)) {
      rows_.otherwise = py::cast<double>(object);
      return;
    }
    array_.emplace(name, object, count, false);
    rows_.data = array_->data();
  }
  const NumberRows& rows() const { return rows_; }

 private:
  std::optional<PlainArray<double>> array_;
  NumberRows rows_;
};

/// Rays, as every call takes them.
struct Rays {
  VectorArray origins, directions;
  NumberArray t_min, t_max;
  PlainArray<double> kept_origins, kept_directions;
  RayArrays batch;

  /// `keep_o` and `keep_d`: where the rays are to be copied to, or None.
  Rays(const py::object& o, const py::object& d, const py::object& from, const py::object& to,
       int cull, const py::object& keep_o = py::none(), const py::object& keep_d = py::none())
      : origins("origins", o),
        directions("directions", d),
        t_min("t_min", from, origins.count()),
        t_max("t_max", to, origins.count()),
        kept_origins("kept origins", keep_o, 3 * origins.count()),
        kept_directions("kept directions", keep_d, 3 * origins.count()) {
    if (directions.count() != origins.count())
      fail_array("directions", directions.found(), "one for each origin");
    batch = {origins.count(), origins.rows(),          directions.rows(),   t_min.rows(),
             t_max.rows(),    static_cast<Cull>(cull), kept_origins.data(), kept_directions.data()};
  }
  /// Of hits that were found before: their stretch is of no matter.
  Rays(const py::object& o, const py::object& d)
      : Rays(o, d, py::float_(0.0), py::float_(0.0), 0) {}
};

/// The hits that `attributes` and `spawn` look up.
struct FoundHits {
  PlainArray<double> t, uv;
  PlainArray<uint32_t> instance, primitive;

  FoundHits(const py::tuple& arrays, size_t count)
      : t("t", arrays[0], count, false),
        uv("uv", arrays[3], 2 * count, false),
        instance("instance", arrays[1], count, false),
        primitive("primitive", arrays[2], count, false) {
    if (count > 0 && !(t.data() && uv.data() && instance.data() && primitive.data()))
      fail_array("hits", "some of the arrays", "t, instance, primitive and uv");
  }
  ConstHitArrays arrays() const { return {t.data(), instance.data(), primitive.data(), uv.data()}; }
};

/// Calls work(control). Few rays are traced at once, since to start a thread would take longer.
template <typename Work>
void trace(size_t count, int threads, const Work& work) {
  constexpr size_t kFew = 4096;
  if (count <= kFew) {
    const GilRelease release;
    work(QueryControl{});
    return;
  }
  run_interruptibly([&](const std::atomic<bool>& cancelled) {
    work(QueryControl{.threads = threads, .cancelled = &cancelled});
  });
}

std::unique_ptr<RayQueries> make_queries(SceneWithBlobs scene, v1::FrameSettings frame,
                                         int threads) {
  return run_abandonably(
      [scene = std::move(scene), frame = std::move(frame), threads](const std::atomic<bool>&) {
        return std::make_unique<RayQueries>(scene.scene, scene.blobs, frame, threads);
      });
}

v1::FrameSettings frame_of(std::optional<double> time, const std::string& camera,
                           const std::string& accelerator, const SceneWithBlobs& scene) {
  if (!camera.empty()) check_camera(camera, scene.scene);
  v1::FrameSettings frame;
  frame.set_time(time.value_or(scene.scene.settings().time()));
  frame.set_camera(camera);
  frame.set_accelerator(accelerator);
  return frame;
}

/// A tessera.Scene, its text form (str) or its binary form (a buffer of bytes).
SceneWithBlobs scene_of(const py::object& scene, const std::string& assets) {
  if (py::isinstance<py::str>(scene)) {
    return run_abandonably([encoded = py::cast<std::string>(scene)](const std::atomic<bool>&) {
      return decode_scene(encoded, SceneEncoding::text, "scene");
    });
  }
  if (PyObject_CheckBuffer(scene.ptr())) {
    const ArraySource bytes = array_source(py::memoryview(scene), "scene");
    if (!bytes.is_plain(kElementOf<uint8_t>))
      fail_array("scene", fmt::format("an array of shape {}", shape_text(bytes.shape)), "bytes");
    return run_abandonably([bytes](const std::atomic<bool>&) {
      const std::string encoded(reinterpret_cast<const char*>(bytes.data),
                                static_cast<size_t>(bytes.count()));
      return decode_scene(encoded, SceneEncoding::binary, "scene");
    });
  }
  return run_abandonably(
      [made = message_of(scene), options = options_of_python(assets)](const std::atomic<bool>&) {
        LoadedScene loaded = load_frame(options, made, 0);
        return SceneWithBlobs{std::move(loaded.scene), std::move(loaded.blobs)};
      });
}

template <typename T>
Array array_of(std::vector<T> values, py::ssize_t width = 0) {
  const auto count = static_cast<py::ssize_t>(values.size());
  return width == 0 ? Array(std::move(values), {count})
                    : Array(std::move(values), {count / width, width});
}

py::tuple intersect_all(const RayQueries& queries, const py::object& o, const py::object& d,
                        const py::object& t_min, const py::object& t_max, int cull, int threads,
                        const py::object& keep_o, const py::object& keep_d) {
  const Rays rays(o, d, t_min, t_max, cull, keep_o, keep_d);
  std::optional<AllHits> all;
  trace(rays.batch.count, threads,
        [&](const QueryControl& control) { all = queries.all_hits(rays.batch, control); });
  return py::make_tuple(array_of(std::move(all->offsets)), array_of(std::move(all->t)),
                        array_of(std::move(all->instance)), array_of(std::move(all->primitive)),
                        array_of(std::move(all->uv), 2));
}

/// Fills two arrays of (height, width, 3) with the rays through the middles of pixels.
void camera_rays(const RayQueries& queries, const std::string& name, int width, int height,
                 int threads, const py::object& origins, const py::object& directions) {
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  const PlainArray<double> o("origins", origins, 3 * pixels);
  const PlainArray<double> d("directions", directions, 3 * pixels);
  trace(pixels, threads, [&](const QueryControl& control) {
    if (!name.empty()) check_camera(name, queries.description());
    const Camera camera = queries.camera(name, width, height);
    for_each_parallel(static_cast<size_t>(height), control.threads, [&](size_t row) {
      for (int column = 0; column < width; ++column) {
        const Ray ray = camera.ray(column + 0.5, static_cast<double>(row) + 0.5);
        const size_t at = 3 * (row * static_cast<size_t>(width) + static_cast<size_t>(column));
        for (int a = 0; a < 3; ++a) {
          o.data()[at + static_cast<size_t>(a)] = ray.origin[a];
          d.data()[at + static_cast<size_t>(a)] = ray.direction[a];
        }
      }
    });
  });
}

py::dict statistics(const RayQueries& queries) {
  const AcceleratorStatistics s = queries.statistics();
  py::dict out;
  out["instances"] = queries.scene().instances.size();
  out["primitives"] = s.primitives;
  out["nodes"] = s.nodes;
  out["leaves"] = s.leaves;
  out["references"] = s.references;
  out["depth"] = s.depth;
  out["bytes"] = s.bytes;
  out["build_seconds"] = s.build_seconds;
  return out;
}

void bind_queries(py::class_<RayQueries, std::shared_ptr<RayQueries>>& tracer) {
  tracer
      .def("intersect",
           [](const RayQueries& queries, const py::object& o, const py::object& d,
              const py::object& t_min, const py::object& t_max, int cull, int threads,
              const py::object& keep_o, const py::object& keep_d, const py::object& t,
              const py::object& instance, const py::object& primitive, const py::object& uv) {
             const Rays rays(o, d, t_min, t_max, cull, keep_o, keep_d);
             const size_t count = rays.batch.count;
             const PlainArray<double> t_out("t", t, count), uv_out("uv", uv, 2 * count);
             const PlainArray<uint32_t> instance_out("instance", instance, count),
                 primitive_out("primitive", primitive, count);
             trace(count, threads, [&](const QueryControl& control) {
               queries.closest_hits(
                   rays.batch,
                   {t_out.data(), instance_out.data(), primitive_out.data(), uv_out.data()},
                   control);
             });
           })
      .def("occluded",
           [](const RayQueries& queries, const py::object& o, const py::object& d,
              const py::object& t_min, const py::object& t_max, int cull, int threads,
              const py::object& out) {
             const Rays rays(o, d, t_min, t_max, cull);
             const PlainArray<uint8_t> result("out", out, rays.batch.count);
             trace(rays.batch.count, threads, [&](const QueryControl& control) {
               queries.occluded(rays.batch, result.data(), control);
             });
           })
      .def("intersect_all", intersect_all)
      .def(
          "crossings",
          [](const RayQueries& queries, const py::object& o, const py::object& d,
             const py::object& t_min, const py::object& t_max, int threads, const py::object& out) {
            const Rays rays(o, d, t_min, t_max, 0);
            const PlainArray<int32_t> result("out", out, rays.batch.count);
            trace(rays.batch.count, threads, [&](const QueryControl& control) {
              queries.crossings(rays.batch, result.data(), control);
            });
          })
      .def("contains",
           [](const RayQueries& queries, const py::object& points,
              const std::optional<std::vector<uint32_t>>& among, bool by_winding, int threads,
              const py::object& out) {
             const auto open =
                 by_winding ? RayQueries::OpenInside::by_winding : RayQueries::OpenInside::nothing;
             const VectorArray at("points", points);
             const PlainArray<uint8_t> result("out", out, at.count());
             trace(at.count(), threads, [&](const QueryControl& control) {
               queries.contains(at.count(), at.rows(), among, open, result.data(), control);
             });
           })
      .def("open_shapes",
           [](const std::shared_ptr<RayQueries>& queries) {
             return run_abandonably([queries](const std::atomic<bool>&) {
               std::vector<std::tuple<uint32_t, bool, size_t, uint32_t, uint32_t>> found;
               for (const RayQueries::OpenShape& shape : queries->open_shapes())
                 found.emplace_back(shape.instance, shape.is_mesh, shape.edges, shape.from,
                                    shape.to);
               return found;
             });
           })
      .def("attributes",
           [](const RayQueries& queries, const py::object& o, const py::object& d,
              const py::tuple& hits, int threads, const py::dict& out) {
             const Rays rays(o, d);
             const size_t n = rays.batch.count;
             const FoundHits found(hits, n);
             const auto wanted = [&](const char* name) -> py::object {
               return out.contains(name) ? py::object(out[name]) : py::none();
             };
             const PlainArray<double> point("point", wanted("point"), 3 * n),
                 error("point_error", wanted("point_error"), 3 * n),
                 normal("normal", wanted("normal"), 3 * n),
                 shading("shading_normal", wanted("shading_normal"), 3 * n),
                 texcoord("texcoord", wanted("texcoord"), 2 * n);
             const PlainArray<uint32_t> material("material", wanted("material"), n);
             trace(n, threads, [&](const QueryControl& control) {
               queries.attributes(rays.batch, found.arrays(),
                                  {point.data(), error.data(), normal.data(), shading.data(),
                                   texcoord.data(), material.data()},
                                  control);
             });
           })
      .def("spawn", [](const RayQueries& queries, const py::object& o, const py::object& d,
                       const py::tuple& hits, const py::object& directions, int threads,
                       const py::object& out) {
        const Rays rays(o, d);
        const FoundHits found(hits, rays.batch.count);
        const VectorArray away("directions", directions);
        if (away.count() != rays.batch.count)
          fail_array("directions", away.found(), "one for each hit");
        const PlainArray<double> result("out", out, 3 * rays.batch.count);
        trace(rays.batch.count, threads, [&](const QueryControl& control) {
          queries.spawn(rays.batch, found.arrays(), away.rows(), result.data(), control);
        });
      });
}

}  // namespace

void bind_tracer(py::module_& module) {
  auto tracer = bind_class<RayQueries, std::shared_ptr<RayQueries>>(
      module, "Tracer", "The geometry of a scene, for `tessera.Tracer`.");
  tracer
      .def(py::init([](const py::object& scene, std::optional<double> time,
                       const std::string& camera, const std::string& accelerator, int threads,
                       const std::string& assets) {
        const SceneWithBlobs made = scene_of(scene, assets);
        return make_queries(made, frame_of(time, camera, accelerator, made), threads);
      }))
      .def("scene",
           [](const RayQueries& queries) {
             return array_of(run_abandonably([scene = queries.description(),
                                              blobs = queries.blobs()](const std::atomic<bool>&) {
               const std::string encoded = encode_scene(scene, blobs, SceneEncoding::binary);
               return std::vector<uint8_t>(encoded.begin(), encoded.end());
             }));
           })
      .def("camera_rays", camera_rays)
      .def("size",
           [](const RayQueries& queries) {
             return py::make_tuple(queries.width(), queries.height());
           })
      .def("bounds",
           [](const RayQueries& queries) {
             const Bounds3 b = queries.bounds();
             return array_of(
                 std::vector<double>{b.min.x, b.min.y, b.min.z, b.max.x, b.max.y, b.max.z}, 3);
           })
      .def("instances", [](const RayQueries& queries) { return queries.instance_names(); })
      .def("materials", [](const RayQueries& queries) { return queries.material_names(); })
      .def("statistics", statistics);
  bind_queries(tracer);
}

}  // namespace tessera
