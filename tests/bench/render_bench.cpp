// The renderer alone, in this process: rays a second, the share of time inside Embree, nanoseconds
// a ray outside it, and what a second thread brings. Prints lines "name value unit".
//
// The share is measured by sampling the program counter (SIGPROF) and asking whether it stands
// inside libembree's text; it is checked by recording the rays that reach Embree and asking for
// them again with nothing in between. Recording goes through the linker's --wrap, so that the
// renderer measured is the one that ships.
#include <fmt/format.h>
#include <link.h>
#include <signal.h>
#include <sys/time.h>
#include <tbb/global_control.h>
#include <ucontext.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/thread_clock.hpp"
#include "common/scene/scene_file.hpp"
#include "worker/accel/embree.hpp"
#include "worker/render/render_task.hpp"
#include "worker/scene/build.hpp"

using namespace tessera;

namespace {

struct RecordedRay {
  RTCScene scene;
  RTCRayHit ray;
  bool any;  ///< it was asked whether it meets anything at all
};
bool recording = false;
std::vector<RecordedRay> recorded;

void record(RTCScene scene, const RTCRayHit& ray) {
  if (recording) recorded.push_back({scene, ray, false});
}
void record(RTCScene scene, const RTCRay& ray) {
  if (recording) recorded.push_back({scene, {.ray = ray}, true});
}

}  // namespace

// The linker sends the renderer's calls of Embree here, and ours to Embree.
extern "C" {
#if RTC_VERSION_MAJOR >= 4
void __real_rtcIntersect1(RTCScene, RTCRayHit*, RTCIntersectArguments*);
void __real_rtcOccluded1(RTCScene, RTCRay*, RTCOccludedArguments*);
void __wrap_rtcIntersect1(RTCScene scene, RTCRayHit* ray, RTCIntersectArguments* arguments) {
  record(scene, *ray);
  __real_rtcIntersect1(scene, ray, arguments);
}
void __wrap_rtcOccluded1(RTCScene scene, RTCRay* ray, RTCOccludedArguments* arguments) {
  record(scene, *ray);
  __real_rtcOccluded1(scene, ray, arguments);
}
#else
void __real_rtcIntersect1(RTCScene, RTCIntersectContext*, RTCRayHit*);
void __real_rtcOccluded1(RTCScene, RTCIntersectContext*, RTCRay*);
void __wrap_rtcIntersect1(RTCScene scene, RTCIntersectContext* context, RTCRayHit* ray) {
  record(scene, *ray);
  __real_rtcIntersect1(scene, context, ray);
}
void __wrap_rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  record(scene, *ray);
  __real_rtcOccluded1(scene, context, ray);
}
#endif
}

namespace {

// ---- where the program counter stands ----

struct TextRange {
  std::uintptr_t low = 0, high = 0;
};
TextRange embree_text;
std::atomic<std::int64_t> ticks_inside{0}, ticks_all{0};

int find_embree(dl_phdr_info* info, std::size_t, void*) {
  if (std::strstr(info->dlpi_name, "libembree") == nullptr) return 0;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& part = info->dlpi_phdr[i];
    if (part.p_type != PT_LOAD || (part.p_flags & PF_X) == 0) continue;
    embree_text = {info->dlpi_addr + part.p_vaddr, info->dlpi_addr + part.p_vaddr + part.p_memsz};
  }
  return 1;
}

void on_tick(int, siginfo_t*, void* context) {
  const auto counter =
      static_cast<std::uintptr_t>(static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_RIP]);
  ticks_all.fetch_add(1, std::memory_order_relaxed);
  if (counter >= embree_text.low && counter < embree_text.high) {
    ticks_inside.fetch_add(1, std::memory_order_relaxed);
  }
}

void set_ticking(bool on) {
  itimerval timer{};
  if (on) timer.it_interval.tv_usec = timer.it_value.tv_usec = 1000;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

void print(const std::string& name, double value, const char* unit) {
  fmt::print("{} {:.4g} {}\n", name, value, unit);
  std::fflush(stdout);
}

// ---- scenes ----

/// A ball of 8·4^levels triangles with hills on it, about `center`.
scene::Mesh hilly_ball(int levels, std::array<double, 3> center, double radius) {
  scene::Mesh mesh;
  mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, fresh] = middles.try_emplace(std::minmax(a, b), 0);
      if (!fresh) return at->second;
      std::array<float, 3> p;
      float square = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = mesh.positions[a][i] + mesh.positions[b][i];
        square += p[i] * p[i];
      }
      for (float& x : p) x /= std::sqrt(square);
      at->second = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(p);
      return at->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    finer.reserve(mesh.triangles.size() * 4);
    for (const auto& t : mesh.triangles) {
      const std::uint32_t a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    mesh.triangles = std::move(finer);
  }
  for (auto& p : mesh.positions) {
    const double hills = std::sin(17.0 * p[0]) * std::sin(19.0 * p[1]) * std::sin(23.0 * p[2]);
    const double fine = std::sin(140.0 * p[0]) * std::sin(150.0 * p[1]) * std::sin(160.0 * p[2]);
    const double r = radius * (1 + 0.08 * hills + 0.01 * fine);
    for (std::size_t i = 0; i < 3; ++i) p[i] = static_cast<float>(center[i] + r * p[i]);
  }
  return mesh;
}

/// What the scene of a million triangles is made of.
struct Surfaces {
  scene::Material walls, side;
  std::array<scene::Material, 3> balls;
};

Surfaces matte() {
  const scene::Material white{.name = "white", .surface = scene::Diffuse{{0.75, 0.75, 0.75}}};
  return {
      white, {.name = "red", .surface = scene::Diffuse{{0.6, 0.1, 0.1}}}, {white, white, white}};
}

scene::Material principled(std::array<double, 3> color, double roughness, double metallic,
                           double clearcoat) {
  scene::Principled out;
  out.base_color.factor = color;
  out.roughness.factor = roughness;
  out.metallic.factor = metallic;
  out.clearcoat.factor = clearcoat;
  return {.name = "principled", .surface = out};
}

/// Paint of two lobes on the walls, a metal, a plastic and a varnish of three lobes on the balls.
Surfaces principled() {
  return {principled({0.75, 0.75, 0.75}, 0.5, 0, 0),
          principled({0.6, 0.1, 0.1}, 0.5, 0, 0),
          {principled({0.9, 0.7, 0.4}, 0.3, 1, 0), principled({0.2, 0.4, 0.7}, 0.2, 0, 0),
           principled({0.6, 0.1, 0.05}, 0.4, 0, 1)}};
}

/// Three such balls in an open box with a lamp: 1,572,864 triangles.
scene::Scene million(Surfaces&& of) {
  scene::Scene scene;
  scene.cameras.emplace_back();
  scene.cameras[0].name = "main";
  scene.cameras[0].eye = {0, 1.1, 4.6};
  scene.cameras[0].target = {0, 0.75, 0};
  scene.materials = {of.walls, of.side, {"lamp", scene::Emitter{{12, 12, 12}, false}}};
  scene.materials.insert(scene.materials.end(), of.balls.begin(), of.balls.end());
  const auto add = [&](auto geometry, std::uint32_t material) {
    scene.shapes.push_back({"", std::move(geometry), material, scene::Transform{}});
  };
  add(scene::Quad{{-2, 0, -2}, {0, 0, 4}, {4, 0, 0}}, 0);
  add(scene::Quad{{-2, 0, -2}, {4, 0, 0}, {0, 3, 0}}, 0);
  add(scene::Quad{{-2, 0, -2}, {0, 3, 0}, {0, 0, 4}}, 1);
  add(scene::Quad{{-0.6, 2.9, -0.6}, {1.2, 0, 0}, {0, 0, 1.2}}, 2);
  add(hilly_ball(8, {-0.9, 0.7, -0.3}, 0.6), 3);
  add(hilly_ball(8, {0.8, 0.65, -0.6}, 0.6), 4);
  add(hilly_ball(8, {0.1, 0.55, 0.8}, 0.5), 5);
  return scene;
}

// ---- measurements ----

render::TaskRequest request_for(int side, std::int64_t samples) {
  render::TaskRequest request;
  request.settings.width = request.settings.height = side;
  request.window = {0, 0, side, side};
  request.samples = {0, samples};
  return request;
}

render::TaskStats run(const render::Scene& scene, const render::TaskRequest& request, int threads) {
  tbb::task_arena arena(threads);
  const auto done = render::render_task(scene, request, arena);
  return done->stats;
}

/// A pass as most of a job's are: of sixteen samples or more.
render::TaskRequest usual_pass() { return request_for(128, 16); }

void measure_share(const std::string& name, const render::Scene& scene) {
  constexpr std::int64_t ticks_wanted = 2500;
  ticks_inside = ticks_all = 0;
  render::TaskStats sum;
  render::TaskRequest request = usual_pass();
  run(scene, request, 1);
  set_ticking(true);
  while (ticks_all < ticks_wanted) {
    request.samples.first += request.samples.count;
    const render::TaskStats stats = run(scene, request, 1);
    sum.rays += stats.rays;
    sum.samples += stats.samples;
    sum.cpu_seconds += stats.cpu_seconds;
  }
  set_ticking(false);
  const double share = static_cast<double>(ticks_inside) / static_cast<double>(ticks_all);
  const double per_ray = sum.cpu_seconds / static_cast<double>(sum.rays) * 1e9;
  print(name + "_mrays_per_second", static_cast<double>(sum.rays) / sum.cpu_seconds * 1e-6,
        "Mray/s");
  print(name + "_rays_per_sample", static_cast<double>(sum.rays) / static_cast<double>(sum.samples),
        "rays");
  print(name + "_sample", sum.cpu_seconds / static_cast<double>(sum.samples) * 1e6, "us");
  print(name + "_ray", per_ray, "ns");
  print(name + "_embree_share", share, "of_time");
  print(name + "_embree_ray", per_ray * share, "ns");
  print(name + "_outside_ray", per_ray * (1 - share), "ns");
  print(name + "_ticks", static_cast<double>(ticks_all), "ticks");
}

void replay(const std::string& name, const render::Scene& scene) {
  recorded.clear();
  recorded.reserve(4'000'000);
  recording = true;
  render::TaskRequest request = usual_pass();
  request.samples.first = request.samples.count;
  run(scene, request, 1);
  recording = false;
  std::vector<double> seconds_of;
  std::int64_t met = 0;
  for (int round = 0; round < 3; ++round) {
    const double began = thread_cpu_seconds();
    for (const RecordedRay& one : recorded) {
      RTCRayHit ray = one.ray;
      if (one.any) {
        accel::embree::occluded(one.scene, ray.ray);
        met += ray.ray.tfar < 0;
      } else {
        accel::embree::intersect(one.scene, ray);
        met += ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
      }
    }
    seconds_of.push_back(thread_cpu_seconds() - began);
  }
  std::sort(seconds_of.begin(), seconds_of.end());
  print(name + "_replayed_ray", seconds_of[1] / static_cast<double>(recorded.size()) * 1e9, "ns");
  if (met == 0) fmt::print("# no ray of {} met anything\n", name);
}

/// Wall clock of one thread over that of two, median of interleaved pairs.
void threads_ratio(const std::string& name, const render::Scene& scene) {
  std::vector<double> ratios;
  const render::TaskRequest request = request_for(256, 16);
  for (int pair = 0; pair < 5; ++pair) {
    const double one = run(scene, request, 1).seconds;
    ratios.push_back(one / run(scene, request, 2).seconds);
  }
  std::sort(ratios.begin(), ratios.end());
  print(name + "_two_threads_over_one", ratios[ratios.size() / 2], "times");
}

enum class Measured { all, share };

void measure(const std::string& name, scene::Scene&& description, Measured what) {
  const double began = thread_cpu_seconds();
  const accel::Device device;
  const render::Scene scene = worker::build_scene(std::move(description), device);
  print(name + "_build", thread_cpu_seconds() - began, "s_of_calling_thread");
  print(name + "_embree_memory", static_cast<double>(device.memory()) * 0x1p-20, "MiB");
  measure_share(name, scene);
  if (what == Measured::share) return;
  replay(name, scene);
  threads_ratio(name, scene);
}

}  // namespace

namespace {

struct Named {
  const char* name;
  scene::Scene (*make)();
};
const Named known[] = {
    {"cornell",
     [] {
       const char* source = std::getenv("TESSERA_SOURCE_DIR");
       const std::filesystem::path root = source != nullptr ? source : ".";
       return scene::load_scene(root / "scenes/cornell.json").scene;
     }},
    {"million", [] { return million(matte()); }},
    {"million_principled", [] { return million(principled()); }},
};

const Named* find(const std::string& name) {
  const Named* const found = std::find_if(std::begin(known), std::end(known),
                                          [&](const Named& one) { return name == one.name; });
  return found == std::end(known) ? nullptr : found;
}

void check(const std::string& name) {
  if (find(name) != nullptr || std::filesystem::exists(name)) return;
  throw Error(ErrorKind::bad_input,
              fmt::format("no scene \"{}\": expected cornell, million, million_principled, or a "
                          "scene's file",
                          name));
}

void measure_one(const std::string& name) {
  const Named* const one = find(name);
  if (one != nullptr) return measure(name, one->make(), Measured::share);
  const std::filesystem::path file = name;
  measure(file.stem().string(), scene::load_scene(file).scene, Measured::share);
}

}  // namespace

/// bench_render [NAME | FILE ...]: all scenes; or the shares alone of those that are named, of
/// cornell, million (matte materials) and million_principled, and of files.
int main(int argc, char** argv) {
  try {
    const tbb::global_control two(tbb::global_control::max_allowed_parallelism, 2);
    dl_iterate_phdr(find_embree, nullptr);
    if (embree_text.high == 0) throw Error(ErrorKind::failed, "libembree is not loaded");
    struct sigaction action {};
    action.sa_sigaction = on_tick;
    action.sa_flags = SA_SIGINFO | SA_RESTART;
    sigaction(SIGPROF, &action, nullptr);
    for (int i = 1; i < argc; ++i) check(argv[i]);
    for (int i = 1; i < argc; ++i) measure_one(argv[i]);
    if (argc > 1) return 0;
    for (const Named& one : known) measure(one.name, one.make(), Measured::all);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
}
