// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/live_model.h"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "atlas/atlas.h"
#include "mesh/base/errors.h"
#include "mesh/base/requirement.h"
#include "planner/geometry_follower.h"
#include "planner/tile_choice.h"
#include "tools/live/background_arena.h"
#include "tools/live/live_coverage.h"
#include "tools/live/waiting.h"

namespace lumatlas {

namespace {

constexpr Requirement live_requires{"live"};

// A view is not decided before the surface has grown if more than this share of its picture has no surface yet.
constexpr double kMuchUnseen = 0.2;
constexpr double kStoringShare = 2;  // as much time for views as for surfaces, times this, while both wait
constexpr int kRenewedAView = 2;     // depths of other views that are made again before the next view is stored
constexpr int kFusedAMove = 2;       // depth frames that are fused, if any wait, before the next one is moved
// A surface that was bent is shown until no frame is fused elsewhere any more, but no longer than this.
constexpr std::chrono::seconds kLongestBent{30};
constexpr std::size_t kMostPassed =
    256;  // views that count for demand and wait for it; of more the first are forgotten

using Poses = std::map<std::string, Camera>;  // by name of the view

void take_pose(const Camera& from, Camera& camera) {
  camera.cam_from_world_rotation = from.cam_from_world_rotation;
  camera.cam_from_world_translation = from.cam_from_world_translation;
}

void add_poses(const Poses& later, Poses& poses) {
  for (const auto& [name, camera] : later) poses.insert_or_assign(name, camera);
}

// Adds the time from its construction to a sum when told so.
class LiveStopwatch {
 public:
  double stop(LiveTimes& times) const {
    const double ms = ms_of(LiveClock::now() - start_);
    ++times.count;
    times.last = ms;
    times.total += ms;
    times.worst = std::max(times.worst, ms);
    return ms;
  }

 private:
  LiveClock::time_point start_ = LiveClock::now();
};

}  // namespace

void check(const LiveOptions& options) {
  live_requires(options.max_views >= 1, "max_views", options.max_views, "at least 1");
  live_requires(options.waiting_views >= 1, "waiting_views", options.waiting_views, "at least 1");
  live_requires(options.waiting_depths >= 1, "waiting_depths", options.waiting_depths, "at least 1");
  live_requires(options.surface_interval.count() > 0, "surface_interval",
                static_cast<double>(options.surface_interval.count()), "above 0");
  live_requires(options.longest_wait.count() > 0, "longest_wait", static_cast<double>(options.longest_wait.count()),
                "above 0");
  check(options.surface);
  PlannerOptions planner = options.planner;
  if (planner.coverage.ideal_distance == 0) planner.coverage.ideal_distance = 1;
  check(planner);
}

// Lock order: none; there is one mutex. The planner belongs to the thread of the views until that has ended, the
// surface to the thread of the depths.
struct LiveModel::State {
  explicit State(const LiveOptions& given) : options(given), planner_options(given.planner), surface(given.surface) {
    start_threads([](const auto& run) { BackgroundArena().run(run); });
  }
  ~State() { end_threads(); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  LiveVerdict offer(const std::string& name, const Camera& camera, PhotographSource photograph);
  void fuse(const std::string& name, const Camera& camera, std::function<DepthImage()> depth);
  bool replace_piece(std::uint32_t id, TriangleSoup piece);
  void move_views(const std::vector<MovedView>& views);
  std::shared_ptr<const Snapshot> snapshot();
  LiveStatus status_now();
  LiveResult finish(std::uint32_t polish_steps, bool follow_moves);

  using Lock = std::unique_lock<std::mutex>;

  const LiveOptions options;
  PlannerOptions planner_options;  // set before `sight` is, and not changed afterwards
  LiveSurface surface;
  std::shared_ptr<Atlas> atlas;
  std::unique_ptr<Planner> planner;
  std::shared_ptr<const Visibility> planner_visibility;

  std::mutex mutex;  // guards all members below
  std::condition_variable changed;
  bool stop = false, finishing = false;
  bool hurries = false;       // what is left is worked off at the priority of the caller
  bool follows_moves = true;  // false: depth frames stay where they were fused
  std::exception_ptr failure;
  std::shared_ptr<Atlas> shown_atlas;  // `atlas`, once there is one

  // The surface that offers are decided on, how many of the given depth frames or pieces it has, and what is covered
  // on it.
  std::shared_ptr<const LiveSight> sight;
  std::uint64_t sight_depths = 0;
  std::unique_ptr<LiveCoverage> coverage;
  std::vector<std::shared_ptr<const LiveSight>> retired;  // that offers may still look at

  std::vector<WaitingView> waiting;
  std::vector<Camera> passed;  // cameras of views that were not needed
  Poses moves;                 // of stored views, which have not taken them yet
  StoringPace pace;
  bool view_is_due = false;  // views have moved since one was stored
  bool views_busy = false;
  ViewsWork views_work;  // of the thread of the views, without the job that runs
  double ViewsWork::*views_job = nullptr;
  LiveClock::time_point views_job_began{};
  bool old_depths = false;  // views wait for the depth that they have on the surface

  std::vector<WaitingDepth> depths;
  Poses depth_moves;  // that the surface has not been told yet; stored views take them with it
  bool depths_busy = false;
  bool bends = false;                  // the surface is being told of poses
  bool is_bent = false;                // the last surface is one that was bent
  bool may_hold = true;                // no version of the surface has been held back since the last one was made
  LiveClock::time_point held_until{};  // since the surface was bent, how long another may wait
  std::map<std::uint32_t, TriangleSoup> pieces;  // that the surface does not have yet
  // Sizes of all pieces, by number, and their sums.
  std::map<std::uint32_t, std::pair<std::size_t, std::size_t>> piece_sizes;
  std::size_t piece_vertices = 0, piece_faces = 0;
  std::uint64_t pieces_taken = 0;   // of those given: the surface has them, or those that replaced them
  bool distance_is_open = false;    // pieces were given, and no view has seen one yet
  std::uint64_t made_of = 0;        // depth frames given, or pieces, that the last surface has
  std::uint64_t fused_unshown = 0;  // depth frames and pieces that the last surface does not have
  LiveClock::time_point next_surface{};
  struct Grown {
    GrownSurface surface;
    std::uint64_t depths = 0;    // of those given; or of the pieces
    std::optional<Poses> moves;  // of the views, if it is the surface before, bent as they have moved
  };
  std::optional<Grown> grown;
  LiveClock::time_point next_taking{};

  std::vector<LiveOutcome> outcomes;
  LiveStatus status;

  std::thread views_thread, depths_thread;

 private:
  template <typename Place>
  void start_threads(const Place& place);
  template <typename Run>
  void run_guarded(const Run& run);
  void join_threads();
  void end_threads();
  // Called with the mutex locked: whether a thread is to return.
  [[nodiscard]] bool is_over() const { return stop || (finishing && !hurries); }
  void require_going() const;

  // A waiting view that is to be decided on the next surface, and what was decided.
  struct Undecided {
    std::uint64_t number;
    Camera camera;
    bool ready;  // is not to wait for another surface
  };
  struct Recount {
    double news = 0;
    bool worth = false;
    std::optional<std::uint32_t> counted;  // see WaitingView; none: the view is turned away
  };

  // Called with the mutex locked.
  [[nodiscard]] bool depths_rest() const {
    return depths.empty() && pieces.empty() && !depths_busy && fused_unshown == 0 && depth_moves.empty() &&
           status.depths_to_move == 0;
  }
  [[nodiscard]] bool all_rests() const;
  [[nodiscard]] bool is_ready(const WaitingView& view, std::uint64_t surface_depths) const;
  [[nodiscard]] std::optional<std::size_t> next_view() const;
  [[nodiscard]] bool may_take_surface() const;
  [[nodiscard]] bool has_surface_to_make() const;
  [[nodiscard]] bool may_make_surface() const;
  [[nodiscard]] bool may_take_depth_moves() const { return !depth_moves.empty() && !grown; }
  // Returns whether stored views are still to take poses that were given.
  [[nodiscard]] bool poses_wait() const {
    return !moves.empty() || !depth_moves.empty() || bends || (grown && grown->moves);
  }
  // Between two sets of poses one view comes, so that poses that come all the time do not keep all views out.
  [[nodiscard]] bool may_store_view() const { return sight && (view_is_due || !poses_wait()); }
  [[nodiscard]] bool is_held() const { return !finishing && held_until > LiveClock::now(); }
  // Depths on a bent surface are nearly those of before, and all become others once its frames have followed.
  [[nodiscard]] bool may_renew_depths() const { return old_depths && !is_held(); }
  void note_passed(const Camera& camera);
  void give_up(std::size_t place, LiveVerdict& verdict);
  void turn_away(const WaitingView& view);
  void forget_given_up(std::map<std::uint64_t, Recount>& recounted, LiveCoverage& fresh) const;
  void take_recounts(const std::map<std::uint64_t, Recount>& recounted);

  // Called with the mutex locked, which they unlock while they work.
  void store_view(Lock& lock, std::size_t place);
  void count_passed(Lock& lock);
  void renew_depth(Lock& lock);
  void take_surface(Lock& lock);
  void take_moves(Lock& lock);
  void count_anew(Lock& lock, std::shared_ptr<const LiveSight> next, std::uint64_t next_depths);
  void fuse_next(Lock& lock);
  void take_depth_moves(Lock& lock);
  void fuse_again(Lock& lock);
  void take_pieces(Lock& lock);
  void make_surface(Lock& lock);
  [[nodiscard]] bool find_distance(const std::vector<Camera>& cameras, bool guesses);

  // Called without the lock.
  void recount(const std::vector<Undecided>& views, const LiveSight& next, LiveCoverage& fresh,
               std::map<std::uint64_t, Recount>& recounted) const;

  [[nodiscard]] ViewsWork work_until_now() const;
  void note_ready(WaitingView& view) const;
  [[nodiscard]] LiveWaits waits_of(const WaitingView& view) const;

  [[nodiscard]] std::vector<ViewPose> stored_poses(const Poses& views) const;

  void run_views();
  void run_depths();
  void start_planner(const GrownSurface& first);
  std::uint64_t offers_ = 0;
};

// Starts both threads, which run their loops in a place: place(loop).
template <typename Place>
void LiveModel::State::start_threads(const Place& place) {
  const auto run = [this, place](void (State::*loop)()) { run_guarded([&] { place([&] { (this->*loop)(); }); }); };
  views_thread = std::thread(run, &State::run_views);
  depths_thread = std::thread(run, &State::run_depths);
}

// Keeps the exception that ends a thread, which every later call throws.
template <typename Run>
void LiveModel::State::run_guarded(const Run& run) {
  try {
    run();
  } catch (...) {
    const std::lock_guard<std::mutex> lock(mutex);
    if (!failure) failure = std::current_exception();
    stop = true;
    changed.notify_all();
  }
}

void LiveModel::State::end_threads() {
  {
    const std::lock_guard<std::mutex> lock(mutex);
    stop = true;
    changed.notify_all();
  }
  join_threads();
}

void LiveModel::State::join_threads() {
  if (views_thread.joinable()) views_thread.join();
  if (depths_thread.joinable()) depths_thread.join();
}

void LiveModel::State::require_going() const {
  if (failure) std::rethrow_exception(failure);
  if (stop || finishing) throw std::logic_error("live: the model is finished");
}

// Without a surface no view can be stored, so that what waits then does not count.
bool LiveModel::State::all_rests() const {
  if (!depths_rest() || grown || !moves.empty() || views_busy || old_depths) return false;
  return !sight || (waiting.empty() && passed.empty());
}

bool LiveModel::State::is_ready(const WaitingView& view, std::uint64_t surface_depths) const {
  return !view.for_depths || surface_depths >= *view.for_depths || (depths_rest() && !grown);
}

// The most urgent view first, of equals the one that was offered first. None while others are to move: it would be
// refined by what they show elsewhere.
std::optional<std::size_t> LiveModel::State::next_view() const {
  if (!may_store_view()) return std::nullopt;
  const LiveClock::time_point now = LiveClock::now();
  const auto is_before = [&](const WaitingView& a, const WaitingView& b) {
    return urgency(a, now, options.longest_wait) > urgency(b, now, options.longest_wait);
  };
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < waiting.size(); ++i) {
    if (!is_ready(waiting[i], sight_depths)) continue;
    if (!best || is_before(waiting[i], waiting[*best])) best = i;
  }
  return best;
}

// Poses do not wait. Otherwise views are stored, if any are ready, for kStoringShare times as long as the last surface
// took to be taken over.
bool LiveModel::State::may_take_surface() const {
  return grown && (grown->moves || !depth_moves.empty() || !next_view() || LiveClock::now() >= next_taking);
}

// The distance that pieces are seen from comes of the views that wait.
bool LiveModel::State::has_surface_to_make() const {
  return fused_unshown > 0 && !grown && (!distance_is_open || finishing || !waiting.empty());
}

bool LiveModel::State::may_make_surface() const {
  if (!has_surface_to_make()) return false;
  return finishing ? depths.empty() && depth_moves.empty() && status.depths_to_move == 0
                   : !is_held() && LiveClock::now() >= next_surface;
}

void LiveModel::State::note_passed(const Camera& camera) {
  if (passed.size() == kMostPassed) passed.erase(passed.begin());
  passed.push_back(camera);
}

LiveVerdict LiveModel::State::offer(const std::string& name, const Camera& camera, PhotographSource photograph) {
  check(camera);
  if (!photograph) throw std::invalid_argument("live: view " + name + ": there is no function for its photograph");
  const LiveClock::time_point now = LiveClock::now();
  Lock lock(mutex);
  require_going();
  std::shared_ptr<const LiveSight> looked_at = sight;
  Sighting seen;
  for (int look = 0; looked_at && look < 2; ++look) {  // again if the surface has changed meanwhile
    lock.unlock();
    seen = sighting_of(*looked_at, camera, planner_options);
    lock.lock();
    if (looked_at == sight) break;
    looked_at = sight;
    seen = {};
  }
  require_going();
  ++status.offered;
  LiveVerdict verdict;
  bool worth = false;
  verdict.news = 1;
  if (sight) {
    coverage->add_demand(seen);
    verdict.news = coverage->news(seen);
    worth = coverage->is_worth(seen);
  }
  const bool grows = status.depths_given + status.pieces_given > sight_depths;
  if (!worth && !(grows && seen.empty > kMuchUnseen)) {
    verdict.decision = sight ? LiveDecision::not_needed : LiveDecision::not_covered;
    ++status.not_needed;
    note_passed(camera);
    changed.notify_all();
    return verdict;
  }
  verdict.decision = worth ? LiveDecision::chosen : LiveDecision::not_yet;
  WaitingView view{name, camera, std::move(photograph), now, offers_++, verdict.news, {}, {}, {}, {}};
  note_ready(view);
  if (!worth) view.for_depths = status.depths_given + status.pieces_given;
  const std::uint64_t number = view.number;
  waiting.push_back(std::move(view));
  while (const std::optional<std::size_t> place =
             one_too_many(waiting, options.waiting_views, pace.most_decided(options.longest_wait))) {
    give_up(*place, verdict);
  }
  // The newest is last. It is counted once it is known to wait.
  if (sight && !waiting.empty() && waiting.back().number == number) {
    waiting.back().counted = coverage->add_waiting(seen);
  }
  changed.notify_all();
  return verdict;
}

void LiveModel::State::give_up(std::size_t place, LiveVerdict& verdict) {
  WaitingView view = std::move(waiting[place]);
  waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(place));
  if (view.counted) coverage->remove_waiting(*view.counted);
  ++status.dropped;
  note_passed(view.camera);
  verdict.dropped.push_back(std::move(view.name));
}

void LiveModel::State::fuse(const std::string& name, const Camera& camera, std::function<DepthImage()> depth) {
  check(camera);
  if (!depth) throw std::invalid_argument("live: there is no function for the depth frame");
  const std::lock_guard<std::mutex> lock(mutex);
  require_going();
  if (status.pieces_given > 0) throw std::logic_error("live: a depth frame comes after pieces of surface");
  ++status.depths_given;
  depths.push_back({name, camera, std::move(depth)});
  if (depths.size() > options.waiting_depths) {
    depths.erase(depths.begin() + static_cast<std::ptrdiff_t>(most_alike(depths)));
    ++status.depths_dropped;
  }
  changed.notify_all();
}

bool LiveModel::State::replace_piece(std::uint32_t id, TriangleSoup piece) {
  check_piece(piece);
  if (piece.faces.empty()) piece = {};
  TriangleSoup replaced;  // is freed without the lock
  const std::lock_guard<std::mutex> lock(mutex);
  require_going();
  if (status.depths_given > 0) throw std::logic_error("live: a piece of surface comes after depth frames");
  const auto before = piece_sizes.find(id);
  std::pair<std::size_t, std::size_t> old;
  if (before != piece_sizes.end()) old = before->second;
  const std::size_t most = options.surface.max_piece_faces;
  const std::size_t vertices = piece_vertices - old.first + piece.positions.size();
  const std::size_t faces = piece_faces - old.second + piece.faces.size();
  if (std::max(vertices, faces) > most) {
    ++status.pieces_refused;
    status.last_failure = "the pieces of surface would have more than " + std::to_string(most) + " faces or vertices";
    return false;
  }
  if (status.pieces_given == 0) distance_is_open = true;
  ++status.pieces_given;
  piece_vertices = vertices;
  piece_faces = faces;
  piece_sizes[id] = {piece.positions.size(), piece.faces.size()};
  if (piece.faces.empty()) piece_sizes.erase(id);
  replaced = std::exchange(pieces[id], std::move(piece));
  changed.notify_all();
  return true;
}

void LiveModel::State::move_views(const std::vector<MovedView>& views) {
  Poses poses;
  for (const MovedView& view : views) {
    check(view.camera);
    poses.insert_or_assign(view.name, view.camera);
  }
  const std::lock_guard<std::mutex> lock(mutex);
  require_going();
  for (WaitingView& view : waiting) {
    if (const auto moved = poses.find(view.name); moved != poses.end()) view.camera = moved->second;
  }
  for (WaitingDepth& frame : depths) {
    const auto moved = frame.name.empty() ? poses.end() : poses.find(frame.name);
    if (moved != poses.end()) take_pose(moved->second, frame.camera);
  }
  add_poses(poses, status.depths_given > 0 ? depth_moves : moves);
  changed.notify_all();
}

std::shared_ptr<const Snapshot> LiveModel::State::snapshot() {
  std::shared_ptr<Atlas> from;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    if (failure) std::rethrow_exception(failure);
    from = shown_atlas;
  }
  return from ? std::make_shared<const Snapshot>(from->snapshot()) : nullptr;
}

LiveStatus LiveModel::State::status_now() {
  const std::lock_guard<std::mutex> lock(mutex);
  if (failure) std::rethrow_exception(failure);
  LiveStatus now = status;
  now.waiting = static_cast<std::uint32_t>(waiting.size());
  now.surface_rests = depths_rest() && !grown && views_job != &ViewsWork::surfaces;
  return now;
}

ViewsWork LiveModel::State::work_until_now() const {
  ViewsWork work = views_work;
  if (views_job != nullptr) work.*views_job += ms_of(LiveClock::now() - views_job_began);
  return work;
}

// Notes that a view waits for nothing but the thread of the views from now on.
void LiveModel::State::note_ready(WaitingView& view) const {
  view.ready = LiveClock::now();
  view.work_before = work_until_now();
}

LiveWaits LiveModel::State::waits_of(const WaitingView& view) const {
  const ViewsWork work = work_until_now();
  LiveWaits waits;
  waits.for_surface = ms_of(view.ready - view.offered);
  waits.behind_surface = work.surfaces + work.moves - view.work_before.surfaces - view.work_before.moves;
  waits.behind_views = work.views - view.work_before.views;
  waits.behind_depths = work.depths - view.work_before.depths;
  return waits;
}

void LiveModel::State::run_views() {
  Lock lock(mutex);
  const auto work = [&](double ViewsWork::*job, const auto& run) {
    views_job_began = LiveClock::now();
    views_job = job;
    run();
    views_job = nullptr;
    views_work.*job += ms_of(LiveClock::now() - views_job_began);
  };
  int renewed = kRenewedAView;  // depths since the last view was stored
  for (;;) {
    // A surface may wait for a time, of which nothing tells.
    changed.wait_for(lock, std::chrono::milliseconds(50), [&] {
      return is_over() || !moves.empty() || may_take_surface() || next_view() || may_renew_depths() ||
             (sight && !passed.empty());
    });
    if (is_over()) return;
    views_busy = true;
    const std::optional<std::size_t> due = view_is_due && poses_wait() ? next_view() : std::nullopt;
    if (due) {
      work(&ViewsWork::views, [&] { store_view(lock, *due); });
    } else if (!moves.empty() && sight) {
      work(&ViewsWork::moves, [&] { take_moves(lock); });
    } else if (!moves.empty()) {
      moves.clear();  // no view is stored
    } else if (may_take_surface()) {
      work(grown->moves ? &ViewsWork::moves : &ViewsWork::surfaces, [&] { take_surface(lock); });
    } else if (const std::optional<std::size_t> view = next_view();
               view && (!may_renew_depths() || renewed >= kRenewedAView)) {
      work(&ViewsWork::views, [&] { store_view(lock, *view); });
      renewed = 0;
    } else if (may_renew_depths()) {
      work(&ViewsWork::depths, [&] { renew_depth(lock); });
      ++renewed;
    } else if (sight && !passed.empty()) {
      count_passed(lock);
    }
    views_busy = false;
    changed.notify_all();
  }
}

void LiveModel::State::store_view(Lock& lock, std::size_t place) {
  view_is_due = false;
  WaitingView view = std::move(waiting[place]);
  waiting.erase(waiting.begin() + static_cast<std::ptrdiff_t>(place));
  LiveOutcome outcome{view.name, {}, {}, 0, waits_of(view)};
  lock.unlock();
  const LiveStopwatch stopwatch;
  try {
    outcome.verdict = planner->offer(view.name, view.camera, view.photograph);
  } catch (const std::exception& error) {
    outcome.failure = error.what();
  }
  outcome.until_stored = ms_of(LiveClock::now() - view.offered);
  lock.lock();
  outcome.waits.storing = stopwatch.stop(status.storing);
  pace.note_stored(view, LiveClock::now(), work_until_now());
  if (view.counted) coverage->remove_waiting(*view.counted);
  for (ViewSlot slot{0}; slot < options.max_views; ++slot) {
    if (!coverage->follow(planner->store(), slot)) continue;
    lock.unlock();  // between two views, for offers that wait
    lock.lock();
  }
  status.held = planner->store().held_views();
  status.summed_coverage = planner->store().summed_coverage();
  const Decision decision = outcome.verdict.decision;
  if (!outcome.failure.empty()) {
    ++status.failed;
    status.last_failure = outcome.failure;
  } else if (decision == Decision::outlier) {
    ++status.outliers;
  } else if (decision == Decision::rejected) {
    ++status.not_needed;
  } else {
    ++status.stored;
  }
  outcomes.push_back(std::move(outcome));
}

// Makes the depth of one view follow the last surface.
void LiveModel::State::renew_depth(Lock& lock) {
  lock.unlock();
  const LiveStopwatch stopwatch;
  (void)GeometryFollower(*planner).renew_depth();
  lock.lock();
  stopwatch.stop(status.depth_renewing);
  old_depths = GeometryFollower(*planner).has_old_depths();
}

// Views that were not needed count for what the stream asks for.
void LiveModel::State::count_passed(Lock& lock) {
  const Camera camera = passed.front();
  passed.erase(passed.begin());
  lock.unlock();
  planner->count_demand(camera);
  lock.lock();
}

void LiveModel::State::start_planner(const GrownSurface& first) {
  double& distance = planner_options.coverage.ideal_distance;
  if (distance == 0) distance = surface.usual_distance();
  atlas = std::make_shared<Atlas>(first.surface, options.max_views, kWholeViews, choose_tiles);
  planner = std::make_unique<Planner>(*atlas, *first.visibility, planner_options);
}

void LiveModel::State::take_surface(Lock& lock) {
  Grown next = std::move(*grown);
  grown.reset();
  if (next.moves) view_is_due = true;
  changed.notify_all();
  lock.unlock();
  const LiveStopwatch stopwatch;
  if (next.moves) {
    GeometryFollower(*planner).move_scene(next.surface.surface, *next.surface.visibility, stored_poses(*next.moves));
  } else if (planner) {
    GeometryFollower(*planner).update_surface(next.surface.surface, *next.surface.visibility,
                                              next.surface.previous_cell, next.surface.changed, DepthRenewal::later);
  } else {
    start_planner(next.surface);
  }
  planner_visibility = next.surface.visibility;
  lock.lock();
  shown_atlas = atlas;
  old_depths = GeometryFollower(*planner).has_old_depths();
  status.faces = next.surface.surface->mesh.faces.size();
  status.cells = next.surface.surface->cells.cells.size();
  status.summed_coverage = planner->store().summed_coverage();
  count_anew(lock, std::make_shared<const LiveSight>(LiveSight{next.surface.surface, next.surface.visibility}),
             next.depths);
  const double ms = stopwatch.stop(next.moves ? status.moving : status.surface_taking);
  next_taking = LiveClock::now() + std::chrono::microseconds(static_cast<std::int64_t>(1000 * kStoringShare * ms));
}

// Returns the poses of those of the views that are stored.
std::vector<ViewPose> LiveModel::State::stored_poses(const Poses& views) const {
  std::vector<ViewPose> poses;
  for (const ViewSlot slot : planner->store().held_slots()) {
    const auto moved = views.find(planner->store().name_of(slot));
    if (moved != views.end()) poses.push_back({slot, moved->second});
  }
  return poses;
}

void LiveModel::State::take_moves(Lock& lock) {
  const Poses views = std::exchange(moves, {});
  view_is_due = true;
  lock.unlock();
  const LiveStopwatch stopwatch;
  const std::vector<ViewPose> poses = stored_poses(views);
  if (!poses.empty()) GeometryFollower(*planner).move_views(poses);
  lock.lock();
  count_anew(lock, sight, sight_depths);
  stopwatch.stop(status.moving);
}

// Offers go on with the account before, outside the lock, until a new one knows all that waits.
void LiveModel::State::count_anew(Lock& lock, std::shared_ptr<const LiveSight> next, std::uint64_t next_depths) {
  lock.unlock();
  auto fresh = std::make_unique<LiveCoverage>(planner->store(), options.waiting_views + 2, planner_options);
  lock.lock();
  std::map<std::uint64_t, Recount> recounted;
  for (;;) {
    forget_given_up(recounted, *fresh);
    std::vector<Undecided> missing;
    for (const WaitingView& view : waiting) {
      if (!recounted.contains(view.number)) missing.push_back({view.number, view.camera, is_ready(view, next_depths)});
    }
    if (missing.empty()) break;
    lock.unlock();
    recount(missing, *next, *fresh, recounted);
    lock.lock();
  }
  if (sight != next) retired.push_back(std::exchange(sight, std::move(next)));
  sight_depths = next_depths;
  std::swap(coverage, fresh);
  take_recounts(recounted);
  // What was replaced takes milliseconds to free, and the last offer that looks at it is not to do that.
  std::vector<std::shared_ptr<const LiveSight>> unseen;
  std::erase_if(retired, [&](std::shared_ptr<const LiveSight>& old) {
    if (old.use_count() > 1) return false;
    unseen.push_back(std::move(old));
    return true;
  });
  lock.unlock();
  fresh.reset();
  unseen.clear();
  lock.lock();
}

// Views that were given up meanwhile do not count.
void LiveModel::State::forget_given_up(std::map<std::uint64_t, Recount>& recounted, LiveCoverage& fresh) const {
  std::erase_if(recounted, [&](const auto& entry) {
    const bool waits = std::any_of(waiting.begin(), waiting.end(),
                                   [&](const WaitingView& view) { return view.number == entry.first; });
    if (!waits && entry.second.counted) fresh.remove_waiting(*entry.second.counted);
    return !waits;
  });
}

// Decides about the views with the most news first, which may make others needless.
void LiveModel::State::recount(const std::vector<Undecided>& views, const LiveSight& next, LiveCoverage& fresh,
                               std::map<std::uint64_t, Recount>& recounted) const {
  std::vector<std::pair<Sighting, const Undecided*>> sightings;
  sightings.reserve(views.size());
  for (const Undecided& view : views) sightings.emplace_back(sighting_of(next, view.camera, planner_options), &view);
  for (const auto& [seen, view] : sightings) fresh.add_demand(seen);
  std::multimap<double, std::size_t, std::greater<>> by_news;
  for (std::size_t i = 0; i < sightings.size(); ++i) by_news.emplace(fresh.news(sightings[i].first), i);
  for (const auto& [news, i] : by_news) {
    const auto& [seen, view] = sightings[i];
    Recount& result = recounted[view->number];
    result.news = news;
    result.worth = fresh.is_worth(seen);
    if (result.worth || !view->ready) result.counted = fresh.add_waiting(seen);
  }
}

void LiveModel::State::take_recounts(const std::map<std::uint64_t, Recount>& recounted) {
  std::vector<WaitingView> before = std::exchange(waiting, {});
  for (WaitingView& view : before) {
    const Recount& result = recounted.at(view.number);
    if (!result.counted) {
      turn_away(view);
      continue;
    }
    view.news = result.news;
    view.counted = result.counted;
    if (result.worth && view.for_depths) {
      view.for_depths.reset();
      note_ready(view);
    }
    waiting.push_back(std::move(view));
  }
}

void LiveModel::State::turn_away(const WaitingView& view) {
  ++status.not_needed;
  outcomes.push_back({view.name, {}, {}, ms_of(LiveClock::now() - view.offered), {}});
  note_passed(view.camera);
}

void LiveModel::State::run_depths() {
  Lock lock(mutex);
  int fused = 0;  // depth frames since the last one was moved
  for (;;) {
    const auto has_work = [&] {
      return is_over() || !depths.empty() || !pieces.empty() || may_take_depth_moves() || status.depths_to_move > 0 ||
             may_make_surface();
    };
    if (has_surface_to_make() && !finishing) {
      changed.wait_until(lock, std::max(next_surface, held_until), has_work);
    } else {
      changed.wait(lock, has_work);
    }
    if (is_over()) return;
    depths_busy = true;
    if (may_take_depth_moves() && !(is_bent && may_make_surface())) {
      take_depth_moves(lock);
    } else if (!pieces.empty()) {
      take_pieces(lock);
    } else if (may_make_surface()) {
      make_surface(lock);
    } else if (status.depths_to_move > 0 && (depths.empty() || fused >= kFusedAMove)) {
      fuse_again(lock);
      fused = 0;
    } else if (!depths.empty()) {
      fuse_next(lock);
      ++fused;
    }
    depths_busy = false;
    changed.notify_all();
  }
}

void LiveModel::State::fuse_next(Lock& lock) {
  const WaitingDepth frame = std::move(depths.front());
  depths.erase(depths.begin());
  lock.unlock();
  const LiveStopwatch stopwatch;
  bool added = false;
  std::string why = "a depth frame measured nothing, or the surface has no room for it";
  try {
    DepthImage image = frame.depth();
    take_pose(frame.camera, image.camera);
    added = surface.add(image, frame.name);
  } catch (const std::exception& error) {
    why = error.what();
  }
  lock.lock();
  stopwatch.stop(status.fusion);
  if (added) {
    ++fused_unshown;
  } else {
    ++status.depths_refused;
    status.last_failure = why;
  }
}

// Bends the surface as its frames have moved, so that it and the stored views move together.
void LiveModel::State::take_depth_moves(Lock& lock) {
  Poses poses = std::exchange(depth_moves, {});
  bends = true;
  const bool is_shown = !finishing;
  bool has_doubles = false;
  std::optional<GrownSurface> bent;
  if (follows_moves) {
    lock.unlock();
    for (const auto& [name, camera] : poses) surface.move(name, camera);
    if (is_shown) bent = surface.bend();
    has_doubles = surface.has_doubles();
    lock.lock();
    status.depths_to_move = follows_moves ? surface.moved() : 0;
  }
  bends = false;
  if (bent) {
    grown = Grown{std::move(*bent), made_of, std::move(poses)};
    is_bent = true;
    if (has_doubles && std::exchange(may_hold, false)) held_until = LiveClock::now() + kLongestBent;
    fused_unshown = std::max<std::uint64_t>(fused_unshown, 1);  // the next version has another form
  } else {
    add_poses(poses, moves);
  }
}

// Fuses a depth frame at its new pose.
void LiveModel::State::fuse_again(Lock& lock) {
  const bool held = is_held();
  lock.unlock();
  const LiveStopwatch stopwatch;
  bool followed = false;
  std::string why;
  try {
    followed = surface.follow_move();
  } catch (const InputError& error) {
    why = error.what();
  }
  const bool has_doubles = held && surface.has_doubles();
  lock.lock();
  if (followed) {
    stopwatch.stop(status.fusing_again);
    ++fused_unshown;
  }
  if (!why.empty()) status.last_failure = why;
  status.depths_to_move = follows_moves ? surface.moved() : 0;
  if (held && !has_doubles) held_until = {};
}

void LiveModel::State::take_pieces(Lock& lock) {
  std::map<std::uint32_t, TriangleSoup> next = std::exchange(pieces, {});
  pieces_taken = status.pieces_given;
  lock.unlock();
  const std::size_t count = next.size();
  for (auto& [id, piece] : next) surface.replace_piece(id, std::move(piece));
  lock.lock();
  fused_unshown += count;
}

// Returns false if none of the cameras sees a piece, and the distance is not to be guessed.
bool LiveModel::State::find_distance(const std::vector<Camera>& cameras, bool guesses) {
  if (surface.find_distance(cameras)) return true;
  if (guesses) surface.guess_distance();
  return guesses;
}

void LiveModel::State::make_surface(Lock& lock) {
  const std::uint64_t with = status.depths_given - depths.size() + pieces_taken;
  const bool finds_distance = distance_is_open, guesses = finishing;
  const auto show = finishing ? GrowingFusion::Show::everything : GrowingFusion::Show::what_changed;
  std::vector<Camera> cameras;
  if (finds_distance) {
    for (const WaitingView& view : waiting) cameras.push_back(view.camera);
  }
  lock.unlock();
  const LiveStopwatch stopwatch;
  bool has_distance = !finds_distance;
  std::optional<GrownSurface> made;
  std::string why;
  try {
    has_distance = has_distance || find_distance(cameras, guesses);
    if (has_distance) made = surface.grow(show);
  } catch (const InputError& error) {
    why = error.what();
  }
  lock.lock();
  if (has_distance) distance_is_open = false;
  if (!why.empty()) status.last_failure = why;
  status.surface_failure = why;
  LiveTimes looking;  // for a piece that a camera sees, in vain
  const double ms = stopwatch.stop(has_distance ? status.surface_making : looking);
  if (has_distance || !why.empty()) fused_unshown = 0;  // otherwise the pieces wait for the next cameras
  if (made) {
    grown = Grown{std::move(*made), with, std::nullopt};
    made_of = with;
    may_hold = true;
    is_bent = false;
  }
  const auto rest = std::chrono::milliseconds(static_cast<std::int64_t>(ms + status.surface_taking.last));
  next_surface = LiveClock::now() + std::max<std::chrono::milliseconds>(options.surface_interval, rest);
}

LiveResult LiveModel::State::finish(std::uint32_t polish_steps, bool follow_moves) {
  {
    Lock lock(mutex);
    require_going();
    finishing = true;
    follows_moves = follow_moves;
    if (!follow_moves) status.depths_to_move = 0;
    changed.notify_all();
  }
  // No offer comes any more that work would have to give way to: other threads work off the rest.
  join_threads();
  {
    Lock lock(mutex);
    hurries = true;
    // The last surface shows all that was fused, also in blocks that a version before did not show anew.
    if ((sight || grown) && fused_unshown == 0) fused_unshown = 1;
    lock.unlock();
    start_threads([](const auto& run) { run(); });
    lock.lock();
    changed.wait(lock, [&] { return stop || all_rests(); });
  }
  end_threads();
  if (failure) std::rethrow_exception(failure);
  LiveResult result;
  result.planner = planner_options;
  if (!planner) return result;
  for (std::uint32_t step = 0; step < polish_steps; ++step) {
    const PolishStep polished = planner->refiner().polish();
    if (polished.views == 0 || planner->refiner().at_rest()) break;
  }
  planner->refiner().publish_refined();
  atlas->choose_tiles_anew();
  result.snapshot = atlas->snapshot();
  result.snapshot.cell_coverage = planner->store().cell_coverage();
  result.summed_coverage = planner->store().summed_coverage();
  result.stored_bytes = planner->store().stored_bytes();
  return result;
}

LiveModel::LiveModel(const LiveOptions& options) {
  check(options);
  state_ = std::make_unique<State>(options);
}

LiveModel::~LiveModel() = default;

LiveVerdict LiveModel::offer(const std::string& name, const Camera& camera, PhotographSource photograph) {
  return run_alone([&] { return state_->offer(name, camera, std::move(photograph)); });
}

void LiveModel::fuse(const std::string& name, const Camera& camera, std::function<DepthImage()> depth) {
  state_->fuse(name, camera, std::move(depth));
}

bool LiveModel::replace_piece(std::uint32_t id, TriangleSoup piece) {
  return state_->replace_piece(id, std::move(piece));
}

void LiveModel::move_views(const std::vector<MovedView>& views) {
  state_->move_views(views);
}

std::shared_ptr<const Snapshot> LiveModel::snapshot() const {
  return state_->snapshot();
}

LiveStatus LiveModel::status() const {
  return state_->status_now();
}

std::vector<LiveOutcome> LiveModel::take_outcomes() {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return std::exchange(state_->outcomes, {});
}

LiveResult LiveModel::finish(std::uint32_t polish_steps, bool follow_moves) {
  return state_->finish(polish_steps, follow_moves);
}

}  // namespace lumatlas
