#pragma once
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/coordinator/frame_film.hpp"
#include "server/schedule/scheduler.hpp"
#include "server/store/store.hpp"
#include "tests/sim/world.hpp"

namespace tessera::sim {

/// The real scheduler, the real films and the real store, with a disk that fails and a pool that
/// takes its time. Checks the scheduler's rules at every grant, and at every start that the store
/// holds what it said. A restart loses all that is not on the disk.
class Coordinator {
 public:
  explicit Coordinator(World& world) : world_(world) {}

  [[nodiscard]] bool up() const { return scheduler_ != nullptr; }
  /// Opens the store; if the disk does not let it, tries again later.
  void start();
  /// The process ends, or the machine loses its power.
  void kill(bool power);
  /// A client that asks until the job is taken.
  void submit(const JobSpec& spec);
  void cancel(JobId job);
  void pause(JobId job, double duration);
  /// No focus: as before any.
  void set_focus(JobId job, const std::optional<Rect>& focus);
  [[nodiscard]] bool all_ended() const;
  /// Once a second: no worker idles while a task waits, and nobody silent is kept.
  void look_around();

  // ---- what arrives from workers ----
  void hello(const Link& link, const server::WorkerInfo& info);
  void preparing(const Link& link, JobId job);
  void ready(const Link& link, JobId job);
  void progress(const Link& link, const std::vector<std::pair<LeaseId, double>>& running);
  void failed(const Link& link, JobId job, const LeaseId& lease);
  void result(const Link& link, const SentResult& sent);
  void bye(const Link& link);
  void closed(const Link& link);

 private:
  struct Arrived {
    Link link;
    server::WorkerId worker = 0;
    SentResult sent;
    Bytes bytes;
    std::shared_ptr<const server::DecodedTile> decoded;
    server::ResultPlace place;
  };
  struct Lease {
    server::WorkerId worker = 0;
    JobId job = 0;
    TaskId task;
  };

  void apply(const server::Actions& actions);
  void granted(const server::GrantLease& grant);
  void shortened(JobId job, std::int64_t samples);
  void shortened(const server::FrameShortened& cut);
  void release(const LeaseId& lease);
  void release_all(server::WorkerId worker);
  void left(const Link& link, bool clean);
  /// False if the connection is not one that this life of the coordinator knows.
  bool heard(const Link& link);
  void arm();
  void later(double delay, std::function<void()> what);
  void decoded(Arrived arrived);

  // ---- coordinator_store.cpp ----
  /// Does it, and gives whether it was done. Where it was not the disk has failed; if that was the
  /// end of the process, the next one is on its way.
  bool done(const char* name, const std::function<void()>& what);
  void restore(const server::JobRecord& record);
  void let_go_of_ended();
  [[nodiscard]] server::JobRecord record_of(JobId job, const std::string& state) const;
  /// That it has begun; asked again until it is done.
  void keep_started(JobId job);
  /// That its time is up, or its noise low enough; false if that is still to be asked.
  bool keep_shortened(JobId job);
  /// … of this frame of several.
  bool keep_shortened(JobId job, std::int32_t frame);
  using Films = std::map<std::int32_t, server::FrameFilm*>;
  void restore_checkpoints(JobId id, const Disk::Job& job, Films& films);
  void restore_results(JobId id, Disk::Job& job, Films& films);
  void tell_folded(JobId id, const Disk::Job& job, const Films& films);
  void commit();
  void append(const std::vector<Arrived>& group, double patience);
  void durable(const Arrived& arrived);
  void end(JobId job, const std::string& state);
  void write_frame(JobId job, std::int32_t frame);
  void finish(JobId job);

  // ---- coordinator_films.cpp ----
  server::FrameFilm& film_of(JobId job, std::int32_t frame);
  void fold_on(JobId job, std::int32_t frame, std::uint32_t tile);
  void fold(JobId job, std::int32_t frame, const server::FoldWork& work);
  std::shared_ptr<server::FilmTile> folded_by(JobId job, std::int32_t frame,
                                              const server::FoldWork& work);
  /// A film of which enough is in the journal is kept whole; one that is left alone is let go of.
  void compact_in_time(JobId job, std::int32_t frame);
  void compact(JobId job, std::int32_t frame);
  void keep_whole(JobId job, std::int32_t frame, const server::FilmSnapshot& film);
  void demand(JobId job, std::int32_t frame);
  // ---- coordinator_noise.cpp ----
  /// Nothing of the frame lacks up to these passes, and nothing beyond has begun.
  void asked(const server::MeasureNoise& look);
  void look(const server::MeasureNoise& look);
  /// Passes of the frame that may be handed out: up to a look that was not answered.
  [[nodiscard]] std::uint32_t offered(JobId job, std::int32_t frame) const;
  /// A pass of the frame has begun, in this life or before.
  void begun(JobId job, const TaskId& task);
  /// Frames that ended by their noise, as far as that was kept.
  void check_shortened(JobId id, Disk::Job& job, const server::JobRecord& record);
  /// Passes that the frame has when it is done.
  [[nodiscard]] std::uint32_t passes_of(JobId job, std::int32_t frame) const;

  /// It has a task that could be leased and is not; with `plain`, one that is no suspect.
  [[nodiscard]] std::optional<TaskId> waits(
      JobId id, bool plain, const std::function<bool(const TaskId&)>& such = {}) const;
  void check_copy(const server::GrantLease& grant, const std::string& what) const;
  void check_focus(const server::GrantLease& grant, const std::string& what) const;
  void check_time(const server::GrantLease& grant, const std::string& what);
  [[nodiscard]] bool quarantined(server::WorkerId worker) const;
  [[nodiscard]] std::string describe(server::WorkerId worker,
                                     const std::vector<JobId>& waiting) const;
  [[nodiscard]] std::uint32_t folded(JobId job, const TaskId& task) const;

  World& world_;
  std::unique_ptr<server::Store> store_;
  std::unique_ptr<server::Scheduler> scheduler_;
  std::uint64_t life_ = 0;  // of the process: what was begun in an earlier one does not go on
  std::optional<Instant> armed_;
  std::map<server::WorkerId, Link> links_;
  std::map<server::WorkerId, Instant> last_byte_;
  std::map<server::WorkerId, std::set<LeaseId>> held_;
  std::map<server::WorkerId, int> idle_looks_;
  std::map<server::WorkerId, Instant> excused_;  // resting after errors
  std::map<LeaseId, Lease> leases_;
  std::map<std::pair<JobId, TaskId>, std::set<LeaseId>> out_;
  std::set<std::pair<JobId, TaskId>> doubted_;  // came back without a result: may be suspects
  std::set<std::pair<JobId, TaskId>> arrived_;  // being decoded or journaled
  std::map<std::pair<JobId, std::int32_t>, server::FrameFilm> films_;
  std::set<JobId> paused_, finishing_;
  std::map<JobId, Digest> builds_;
  std::map<JobId, std::optional<Rect>> focus_;
  std::map<JobId, double> started_;              // the first lease
  std::map<JobId, std::int64_t> shortened_;      // its time is up: samples that it ends with
  std::map<JobId, Digest> plans_;                // what is said with leases of it
  std::map<JobId, std::uint32_t> passes_begun_;  // of jobs whose time is limited
  std::map<std::pair<JobId, std::int32_t>, std::uint32_t> offers_;  // where noise ends frames
  std::set<JobId> late_;  // a pass of them began when time was up
  bool compacting_ = false;
  bool restoring_ = false;
  std::vector<Arrived> journal_;  // decoded, not yet synced
  bool syncing_ = false;

  // Known outside the process, over all of its lives.
  std::uint64_t epoch_ = 0;
  std::optional<std::array<std::uint8_t, 16>> key_;
};

}  // namespace tessera::sim
