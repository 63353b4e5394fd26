#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/process.h"
#include "client/refusal.h"
#include "front/farm_access.h"
#include "front/farm_thread.h"
#include "front/frame_task.h"
#include "front/load_frame.h"
#include "front/picture_warnings.h"
#include "front/render_frame.h"
#include "front/render_options.h"
#include "front/tile_keeping_farm.h"
#include "python/array.h"
#include "python/bindings.h"
#include "python/errors.h"
#include "python/gil.h"
#include "python/interruptible.h"
#include "python/scene_values.h"

namespace py = pybind11;

namespace tessera {
namespace {

using Release = py::call_guard<GilRelease>;

/// The options of a command, each assigned by its long name and a text.
class OptionTexts {
 public:
  /// `of_jobs`: those of `tessera submit` alone.
  explicit OptionTexts(bool of_jobs) {
    of_jobs ? add_scene_options(list_, options) : add_render_options(list_, options);
  }
  OptionTexts(const OptionTexts&) = delete;
  OptionTexts& operator=(const OptionTexts&) = delete;

  void assign(const std::string& name, const OptionValue& value) {
    assign_option(list_, name, value);
  }

  RenderOptions options;

 private:
  OptionList list_;
};

/// What loads a frame of the scene in a file, or of a value as it is now, without the GIL.
std::function<LoadedScene(int frame)> loader_of(RenderOptions& options, const py::object& scene) {
  if (py::isinstance<py::str>(scene)) {
    options.scene = py::cast<std::string>(scene);
    return [options](int frame) { return load_frame(options, frame); };
  }
  options.scene = kSceneOfPython;
  return
      [options, made = message_of(scene)](int frame) { return load_frame(options, made, frame); };
}

/// A task for one frame of `scene`, a path or a value, and what is to be told of that.
std::pair<std::shared_ptr<FrameTask>, std::vector<std::string>> make_task(
    const OptionTexts& texts, const py::object& scene, std::optional<int> frame) {
  RenderOptions options = texts.options;
  auto load = loader_of(options, scene);
  return run_abandonably([options, load = std::move(load), frame](const std::atomic<bool>&) {
    FrameScene made = measured([&] { return load(frame.value_or(0)); });
    std::vector<std::string> warnings = scene_warnings(options, made.loaded);
    auto task = std::make_shared<FrameTask>(options, std::move(made), frame);
    return std::pair(std::move(task), std::move(warnings));
  });
}

/// The share of tiles to be traced twice by so many workers.
double share_verified(const std::string& text, int workers) {
  const double share = parse_share("--verify", text);
  check_verify(share, workers);
  return share;
}

std::shared_ptr<FarmThread> local_farm(std::optional<int> workers, int threads,
                                       const std::string& verify) {
  const int count = workers.value_or(core_count());
  const LocalFarmOptions options{
      .workers = count, .threads = threads, .quiet = true, .verify = share_verified(verify, count)};
  return std::make_shared<FarmThread>(
      [options] { return keep_finished_tiles(start_local_workers(options)); });
}

std::shared_ptr<FarmThread> threads_here(std::optional<int> threads) {
  return std::make_shared<FarmThread>([count = threads.value_or(core_count())] {
    return keep_finished_tiles(start_in_process(count));
  });
}

FarmConnection connection_of(const std::string& endpoint, const std::string& key,
                             const std::string& server_key, double patience) {
  return {.endpoint = endpoint,
          .key_file = key,
          .server_key = server_key,
          .patience = std::chrono::duration_cast<Time>(std::chrono::duration<double>(patience))};
}

std::shared_ptr<FarmThread> remote_farm(const std::string& endpoint, const std::string& key,
                                        const std::string& server_key, double patience) {
  const FarmConnection connection = connection_of(endpoint, key, server_key, patience);
  return std::make_shared<FarmThread>([connection] { return connect_to_farm(connection); });
}

py::tuple tuple_of(const PixelRect& rect) {
  return py::make_tuple(rect.x0, rect.y0, rect.x1, rect.y1);
}

py::list tuples_of(const std::vector<PixelRect>& rects) {
  py::list out;
  for (const PixelRect& rect : rects) out.append(tuple_of(rect));
  return out;
}

/// A job of all frames that the options ask for, and what was told of reading them.
std::pair<uint64_t, std::vector<std::string>> submit(FarmAccess& farm, const OptionTexts& texts,
                                                     const py::object& scene,
                                                     const JobOrder& order) {
  RenderOptions options = texts.options;
  auto load = loader_of(options, scene);
  auto [gathered, warnings] =
      run_abandonably([options, order, load = std::move(load)](const std::atomic<bool>&) {
        std::vector<std::string> told;
        const auto warn = [&](const std::string& warning) { told.push_back(warning); };
        auto job = gather_job(options, order, load, warn);
        return std::pair(std::move(job), std::move(told));
      });
  const uint64_t job = run_interruptibly(
      [&farm, &sent = gathered](const std::atomic<bool>& stop) { return farm.submit(sent, stop); });
  return {job, std::move(warnings)};
}

/// What a farm does to us has classes of its own.
void translate_farm_errors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const RefusedError& error) {
      set_python_error("Refused", error.what(), {{"endpoint", error.endpoint()}});
    } catch (const UnreachableError& error) {
      set_python_error("FarmError", error.what(), {{"endpoint", error.endpoint()}});
    }
  });
}

void bind_access(py::module_& module) {
  using Stop = const std::atomic<bool>&;
  py::enum_<v1::JobQuery::Action>(module, "Order")
      .value("cancel", v1::JobQuery::CANCEL)
      .value("pause", v1::JobQuery::PAUSE)
      .value("resume", v1::JobQuery::RESUME)
      .value("forget", v1::JobQuery::FORGET)
      .value("retry", v1::JobQuery::RETRY);
  bind_class<FetchedPicture>(module, "FetchedPicture")
      .def_readonly("has_ended", &FetchedPicture::has_ended)
      .def_readonly("picture", &FetchedPicture::picture)
      .def("throw_failure", [](const FetchedPicture& fetched) {
        if (fetched.failure) throw *fetched.failure;
      });
  bind_class<FarmAccess, std::shared_ptr<FarmAccess>>(module, "FarmAccess")
      .def(py::init([](const std::string& endpoint, const std::string& key,
                       const std::string& server_key, double patience) {
        return std::make_shared<FarmAccess>(connection_of(endpoint, key, server_key, patience));
      }))
      .def("submit",
           [](FarmAccess& farm, const OptionTexts& options, const py::object& scene,
              const std::string& name, int priority, int weight) {
             return submit(farm, options, scene, {name, priority, weight});
           })
      .def("find",
           [](FarmAccess& farm, const std::string& text) {
             std::vector<std::string> told;
             const auto tell = [&told](const std::string& message) { told.push_back(message); };
             const uint64_t job =
                 run_interruptibly([&](Stop stop) { return farm.find(text, tell, stop); });
             return std::pair(job, told);
           })
      .def("list",
           [](FarmAccess& farm) {
             return run_interruptibly([&](Stop stop) { return farm.list(stop); });
           })
      .def("status",
           [](FarmAccess& farm, uint64_t job) {
             return run_interruptibly([&](Stop stop) { return farm.status(job, stop); });
           })
      .def("order",
           [](FarmAccess& farm, uint64_t job, v1::JobQuery::Action action,
              std::optional<int> priority) {
             run_interruptibly([&](Stop stop) { farm.order(job, action, priority, stop); });
           })
      .def("fetch",
           [](FarmAccess& farm, uint64_t job, uint32_t frame, bool denoises) {
             return run_interruptibly(
                 [&](Stop stop) { return farm.fetch(job, frame, denoises, stop); });
           })
      .def("snapshot",
           [](FarmAccess& farm, uint64_t job, uint32_t frame) {
             return run_interruptibly([&](Stop stop) { return farm.snapshot(job, frame, stop); });
           })
      .def("frames", [](FarmAccess& farm, uint64_t job) {
        return run_interruptibly([&](Stop stop) { return farm.frames(job, stop); });
      });
}

void bind_task(py::module_& module) {
  bind_class<FrameTask, std::shared_ptr<FrameTask>>(module, "Task")
      .def("wait",
           [](const FrameTask& task, double seconds) {
             const GilRelease release;
             return task.wait(std::chrono::microseconds(static_cast<int64_t>(seconds * 1e6)));
           })
      .def("is_done", &FrameTask::is_done)
      .def("cancel", &FrameTask::cancel)
      .def("abandon", &FrameTask::abandon)
      .def("progress",
           [](const FrameTask& task) {
             const JobProgress p = task.progress();
             return py::make_tuple(p.tiles_done, p.tiles_total, p.workers, p.elapsed_seconds,
                                   p.remaining_seconds, p.waiting_for);
           })
      .def("keep_tiles", &FrameTask::keep_tiles)
      .def("take_tiles", [](FrameTask& task) { return tuples_of(task.take_tiles()); })
      .def("snapshot", &FrameTask::snapshot, Release())
      .def("picture", &FrameTask::picture)
      .def("throw_failure", &FrameTask::throw_failure)
      .def("warnings", &FrameTask::warnings);
}

}  // namespace

void bind_render(py::module_& module) {
  bind_class<OptionTexts>(module, "Options")
      .def(py::init<bool>())
      .def("assign", &OptionTexts::assign);
  bind_task(module);
  bind_access(module);
  translate_farm_errors();
  bind_class<FarmThread, std::shared_ptr<FarmThread>>(module, "FarmThread")
      .def("submit", &FarmThread::submit, py::arg().none(false), Release())
      .def("close", &FarmThread::close, Release());
  module.def("make_task", &make_task);
  module.def("share_verified", &share_verified);
  module.def("local_farm", &local_farm, Release());
  module.def("threads_here", &threads_here, Release());
  module.def("remote_farm", &remote_farm, Release());
}

}  // namespace tessera
