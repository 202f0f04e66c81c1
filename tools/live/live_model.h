// SPDX-License-Identifier: GPL-3.0-or-later
// A model of a stream of frames: it grows while a camera moves through the scene, and viewers may draw it all the while
// (Erat et al. 2019, sections 1 and 5, Fig. 1 and 2).
//
//   LiveModel live(LiveOptions{});
//   for (const Frame& frame : stream) {
//     live.fuse(frame.name, frame.camera, [frame] { return frame.depth(); });
//     live.offer(frame.name, frame.camera, [frame] { return frame.photograph(); });
//     if (const auto now = live.snapshot()) draw(*now);
//   }
//   const LiveResult model = live.finish();
//
// A program that has a mesh of its own gives pieces of that instead of depth frames: replace_piece().
//
// offer(), fuse(), replace_piece() and move_views() never wait for work: they decide, put what is to be done into a
// bounded queue, and return. Two threads work. One fuses depth frames and makes surfaces of them. The other stores the
// chosen views and takes over surfaces and poses. Each stored view, surface and set of poses is one edit of the store:
// a snapshot has all of it or nothing. The depths and masks of stored views follow a surface view by view.
//
// All coordinates are relative to one origin near the scene, which the caller subtracts: positions become floats.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/snapshot.h"
#include "planner/planner.h"
#include "tools/live/live_surface.h"
#include "tools/meshing/depth/depth_fusion.h"

namespace lumatlas {

struct LiveOptions {
  std::uint32_t max_views = 100;  // that the store holds, >= 1
  // Options by which each view is judged and refined. coverage.ideal_distance 0: the median distance that the first
  // depth frame measured.
  PlannerOptions planner;
  LiveSurfaceOptions surface;
  std::chrono::milliseconds surface_interval{500};  // between two surfaces at least, > 0; longer where they take longer
  std::uint32_t waiting_views = 24;                 // chosen, and not stored yet; >= 1
  // Where a chosen view would wait longer than this for those before it, by the time that the last views took, fewer
  // chosen views may wait, but 4 at least, or waiting_views if those are fewer. A view that has waited so long comes
  // before one that has just been chosen, whatever their LiveVerdict::news. > 0.
  std::chrono::milliseconds longest_wait{1000};
  std::uint32_t waiting_depths = 8;  // given, and not fused yet; >= 1
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const LiveOptions& options);

enum class LiveDecision {
  chosen,       // waits for a thread to store it
  not_yet,      // sees much that no surface is made of yet: decided once the surface has the depth frames given before
  not_needed,   // adds too little to what is stored or waits
  not_covered,  // sees no surface, and no depth frame waits that could bring one
};

struct LiveVerdict {
  LiveDecision decision = LiveDecision::not_needed;
  double news = 0;                   // share of the picture that it shows better than the store, in [0, 1]
  std::vector<std::string> dropped;  // views that waited and are given up for it; may name the view itself
};

// Divides the time from offer() until a view is stored by what the view waited for, milliseconds.
struct LiveWaits {
  double for_surface = 0;     // for the decision: in offer(), and until the surface had the depth frames before it
  double behind_surface = 0;  // while the thread of the views took over surfaces and poses
  double behind_views = 0;    // while it stored other views
  double behind_depths = 0;   // while it renewed depths of stored views
  double storing = 0;         // while the view was read, refined and stored
};

// Tells the outcome for a view that was chosen or not decided yet.
struct LiveOutcome {
  std::string name;
  Verdict verdict;          // the planner's
  std::string failure;      // why its photograph could not be read; empty: it was read
  double until_stored = 0;  // from offer() until snapshots have it, or it is turned away; milliseconds
  LiveWaits waits;          // of a view whose photograph was asked for
};

// Counts a kind of work, and sums its wall time, milliseconds.
struct LiveTimes {
  std::uint64_t count = 0;
  double last = 0, total = 0, worst = 0;
};

struct LiveStatus {
  std::uint64_t offered = 0, not_needed = 0, dropped = 0, failed = 0;      // views
  std::uint64_t stored = 0, outliers = 0;                                  // views, by the planner
  std::uint32_t held = 0, waiting = 0;                                     // views in the store and in the queue
  std::uint64_t depths_given = 0, depths_dropped = 0, depths_refused = 0;  // refused: unreadable, or no room
  std::uint64_t pieces_given = 0, pieces_refused = 0;                      // of surface; refused: no room
  std::string surface_failure;  // why pieces made no surface, and the one before stays; empty: they did
  LiveTimes fusion, surface_making, surface_taking, depth_renewing, storing;
  LiveTimes moving, fusing_again;      // of stored views, and of depth frames, to their new poses
  std::uint64_t depths_to_move = 0;    // that the surface has at other poses than their last ones
  bool surface_rests = false;          // snapshots have all depth frames, pieces and poses that were given so far
  std::uint64_t faces = 0, cells = 0;  // of the surface
  double summed_coverage = 0;          // of the surface by the stored views, see CoverageLedger
  std::string last_failure;            // of a depth frame, photograph or piece; empty: none
};

struct MovedView {
  std::string name;
  Camera camera;  // that it would be offered with now
};

struct LiveResult {
  Snapshot snapshot;       // without a surface if no depth frame showed one
  PlannerOptions planner;  // with the values in effect
  double summed_coverage = 0;
  std::uint64_t stored_bytes = 0;
};

class LiveModel {
 public:
  // Throws as check() does.
  explicit LiveModel(const LiveOptions& options);
  // Ends as soon as the jobs that run are done. What waits is given up.
  ~LiveModel();
  LiveModel(const LiveModel&) = delete;
  LiveModel& operator=(const LiveModel&) = delete;

  // Every call below is safe from any thread, and throws what ended the work if a thread could not go on.

  // Decides whether to store a view, on this thread: by a picture of the surface as it is now, at
  // planner.visibility_px, and what the store and the waiting views cover. `photograph` is called later, once or never,
  // from another thread; what it throws is noted, and the view left out. Where the queue is full, the view with the
  // least news in it is given up. Throws std::invalid_argument for a bad camera or an empty function.
  LiveVerdict offer(const std::string& name, const Camera& camera, PhotographSource photograph);
  // Adds a depth frame to the surface, see LiveSurface::add(). `depth` is called later, once or never, from another
  // thread; its image is taken from the pose of `camera`. Where the queue is full, the frame whose camera is nearest to
  // another one's is given up. A frame with a name is kept for move_views(); an empty name keeps nothing. Throws as
  // offer().
  void fuse(const std::string& name, const Camera& camera, std::function<DepthImage()> depth);
  // Brings a piece of the surface under a number, replaces the piece that has it, or removes that if the new one has no
  // faces. The surface of the model is the join of all pieces: vertices at the same coordinates are one, so that pieces
  // which meet in them have no seam. Faces count from their front, whose corners turn counterclockwise. The first view
  // that sees a piece gives the distance that cells are made by, and no surface is shown before. The last surface stays
  // while there is no piece, or while pieces make none: see LiveSurface::grow(). move_views() does not move pieces: the
  // caller replaces those that a loop closure moves.
  // Returns false, and keeps the piece before, if all pieces would have more than surface.max_piece_faces faces or
  // vertices. A model has pieces or depth frames: throws std::logic_error if a depth frame was given before, as fuse()
  // does if a piece was; and what check_piece() throws.
  bool replace_piece(std::uint32_t id, TriangleSoup piece);
  // Gives views and depth frames other poses, by name; other names have no effect. Those that wait take them at once.
  // Stored views and the surface take them in one edit, for which the surface is bent: see LiveSurface::bend(). Then
  // each depth frame that was fused is taken out of the surface and fused again, between those that come. Until no
  // frame is off by more than a voxel, and for 30 s at most, the bent surface is shown.
  void move_views(const std::vector<MovedView>& views);
  // Returns the model as it is now; null while there is no surface.
  [[nodiscard]] std::shared_ptr<const Snapshot> snapshot() const;
  [[nodiscard]] LiveStatus status() const;
  // Returns what became of views since the last call, in that order.
  [[nodiscard]] std::vector<LiveOutcome> take_outcomes();

  // Works off all that waits, makes the last surface, and ends the threads. Then refines all views together for at most
  // `polish_steps` steps and brings depths and masks up to date. Without `follow_moves`, depth frames that are to be
  // fused at another pose stay where they are, for a caller that makes the surface anew. To be called once; offers come
  // no more afterwards (std::logic_error).
  LiveResult finish(std::uint32_t polish_steps = 0, bool follow_moves = true);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lumatlas
