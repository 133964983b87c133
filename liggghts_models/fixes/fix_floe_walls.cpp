// SPDX-License-Identifier: GPL-2.0-or-later
#include "fix_floe_walls.h"

#include <algorithm>
#include <cmath>

#include "atom.h"
#include "error.h"
#include "fix_floe_integrate.h"
#include "neighbor.h"
#include "pair_floe.h"
#include "plugin.h"
#include "update.h"

using namespace LAMMPS_NS;
using floe::Vec2;
using floe::WallFace;
using floe::WallPoint;

namespace {

constexpr int faces_per_group = 32;
constexpr int packed = 7;  // numbers of a contact that go to another rank
// A ridge is remembered until the element is this share of its radius away from the wall.
constexpr double memory_share = 0.1;

}  // namespace

FixFloeWalls::FixFloeWalls(LAMMPS *lmp, int narg, char **arg) : Fix(lmp, narg, arg) {
  if (narg > 3) error->all(FLERR, "Fix floe/walls takes no keywords");
  atom->add_callback(0);
}

FixFloeWalls::~FixFloeWalls() { atom->delete_callback(id, 0); }

int FixFloeWalls::setmask() {
  return FixConst::INITIAL_INTEGRATE | FixConst::PRE_EXCHANGE | FixConst::PRE_FORCE |
         FixConst::POST_FORCE;
}

void FixFloeWalls::init() {
  const floe::Parts parts = floe::find_parts(lmp);
  if (!parts.floe || !parts.fix) {
    error->all(FLERR, "Fix floe/walls needs pair_style gran model floe and fix floe/integrate");
  }
  law_ = {parts.floe, parts.fix};
}

void FixFloeWalls::set_walls(std::vector<WallFace> faces, int walls) {
  faces_ = std::move(faces);
  groups_.clear();
  fastest_ = 0.0;
  for (int k = 0; k < static_cast<int>(faces_.size()); ++k) {
    const WallFace &f = faces_[k];
    fastest_ = std::max(fastest_, std::hypot(f.v.x, f.v.y));
    const Vec2 low{std::min(f.a.x, f.b.x), std::min(f.a.y, f.b.y)};
    const Vec2 high{std::max(f.a.x, f.b.x), std::max(f.a.y, f.b.y)};
    // A plane is alone in its group: it has no box.
    const bool joins = !groups_.empty() && groups_.back().count < faces_per_group && !f.plane &&
                       !faces_[k - 1].plane && faces_[k - 1].wall == f.wall;
    if (!joins) {
      groups_.push_back({low, high, k, 1});
      continue;
    }
    Group &g = groups_.back();
    g.low = {std::min(g.low.x, low.x), std::min(g.low.y, low.y)};
    g.high = {std::max(g.high.x, high.x), std::max(g.high.y, high.y)};
    ++g.count;
  }
  force_.assign(2 * walls, 0.0);
  impulse_.assign(2 * walls, 0.0);
  near_.clear();
  parked_.clear();
  work_ = 0.0;
  stale_ = true;
}

double FixFloeWalls::time() const {
  return law_.fix->start_time + static_cast<double>(update->ntimestep) * update->dt;
}

Vec2 FixFloeWalls::moved(const WallFace &face) const {
  const double t = time();
  return {face.v.x * t, face.v.y * t};
}

void FixFloeWalls::setup_pre_exchange() { pre_exchange(); }

void FixFloeWalls::pre_exchange() {
  for (Near &near : near_) {
    if (!near.contacts.empty()) parked_[atom->tag[near.i]] = std::move(near.contacts);
  }
  near_.clear();
  stale_ = true;
}

int FixFloeWalls::pack_exchange(int i, double *buf) {
  int n = 0;
  const auto found = parked_.find(atom->tag[i]);
  if (found == parked_.end()) {
    buf[n++] = 0.0;
    return n;
  }
  buf[n++] = static_cast<double>(found->second.size());
  for (const Contact &c : found->second) {
    const floe::WallHistory &h = c.history;
    for (double value : {static_cast<double>(c.face), h.slip, h.rest_overlap, h.ridge.closing,
                         h.ridge.thickness, h.ridge.length, h.ridge.cover}) {
      buf[n++] = value;
    }
  }
  parked_.erase(found);
  return n;
}

int FixFloeWalls::unpack_exchange(int i, double *buf) {
  const int count = static_cast<int>(buf[0]);
  for (int k = 0; k < count; ++k) {
    const double *row = buf + 1 + packed * k;
    put(atom->tag[i],
        {static_cast<int>(row[0]), {row[1], row[2], {row[3], row[4], row[5], row[6]}}});
  }
  return 1 + packed * count;
}

void FixFloeWalls::setup_pre_force(int) {
  if (stale_) build();
}

void FixFloeWalls::pre_force(int) {
  if (stale_) {
    build();
  } else if (fastest_ * std::fabs(time() - built_at_) > 0.5 * neighbor->skin) {
    pre_exchange();  // the walls have moved
    build();
  }
}

void FixFloeWalls::build() {
  near_.clear();
  candidates_.clear();
  for (int i = 0; i < atom->nlocal; ++i) {
    if (atom->type[i] == FixFloeIntegrate::fixed_type) continue;
    const Vec2 x{atom->x[i][0], atom->x[i][1]};
    const double r = atom->radius[i];
    // Elements and walls may each move by half a skin until the next time.
    const double reach = (1.0 + memory_share) * r + 1.5 * neighbor->skin;
    Near near{i, static_cast<int>(candidates_.size()), 0, {}};
    const auto held = parked_.find(atom->tag[i]);
    if (held != parked_.end()) near.contacts = std::move(held->second);
    for (const Group &g : groups_) {
      const WallFace &face = faces_[g.first];
      const Vec2 m = moved(face);
      if (!face.plane && (x.x < g.low.x + m.x - reach || x.x > g.high.x + m.x + reach ||
                          x.y < g.low.y + m.y - reach || x.y > g.high.y + m.y + reach)) {
        continue;
      }
      for (int k = g.first; k < g.first + g.count; ++k) {
        if (floe::wall_point(faces_[k], m, x).distance < reach) candidates_.push_back(k);
      }
    }
    // A contact may reach across a gap.
    for (const Contact &c : near.contacts) {
      const auto begin = candidates_.begin() + near.first;
      if (std::find(begin, candidates_.end(), c.face) == candidates_.end()) {
        candidates_.push_back(c.face);
      }
    }
    near.count = static_cast<int>(candidates_.size()) - near.first;
    if (near.count > 0) near_.push_back(std::move(near));
  }
  parked_.clear();
  built_at_ = time();
  stale_ = false;
}

// The contact from which one with this face goes on: that with it, or with a neighbour that the element
// has slid off (its face is not among those that count now).
const FixFloeWalls::Contact *FixFloeWalls::past(const Near &near, int face,
                                                const std::vector<int> &now) const {
  for (const Contact &c : near.contacts) {
    if (c.face == face) return &c;
  }
  for (const Contact &c : near.contacts) {
    const bool beside = c.face == faces_[face].before || c.face == faces_[face].after;
    if (beside && std::find(now.begin(), now.end(), c.face) == now.end()) return &c;
  }
  return nullptr;
}

// Calls visit(face, pose, history) for each face that counts for the element.
template <typename Visit>
void FixFloeWalls::each_contact(const Near &near, Visit visit) const {
  const int i = near.i;
  const Vec2 x{atom->x[i][0], atom->x[i][1]}, v{atom->v[i][0], atom->v[i][1]};
  const auto shift = [this](const WallFace &face) { return moved(face); };
  std::vector<int> now;
  std::vector<WallPoint> points;
  for (int c = near.first; c < near.first + near.count; ++c) {
    const int k = candidates_[c];
    const WallPoint at = floe::wall_point(faces_[k], moved(faces_[k]), x);
    if (!floe::wall_point_counts(faces_, k, at, shift, x)) continue;
    now.push_back(k);
    points.push_back(at);
  }
  for (std::size_t n = 0; n < now.size(); ++n) {
    const Contact *before = past(near, now[n], now);
    if (!before && !(points[n].distance < atom->radius[i])) continue;
    const WallFace &face = faces_[now[n]];
    const floe::ContactPose pose{points[n].d,
                                 points[n].distance,
                                 atom->radius[i],
                                 0.0,
                                 {face.v.x - v.x, face.v.y - v.y},
                                 atom->omega[i][2],
                                 0.0};
    visit(now[n], pose, before ? before->history : floe::WallHistory{});
  }
}

void FixFloeWalls::advance(Near &near, double step) {
  const int i = near.i;
  std::vector<Contact> kept;
  each_contact(near, [&](int face, const floe::ContactPose &pose, floe::WallHistory history) {
    const floe::ContactForce f = law_.force(i, atom->rmass[i], pose, step, history);
    atom->f[i][0] += f.f.x;
    atom->f[i][1] += f.f.y;
    atom->torque[i][2] += f.torque_one;
    force_[2 * faces_[face].wall] += f.f.x;
    force_[2 * faces_[face].wall + 1] += f.f.y;
    // A contact that is open holds nothing, but where a ridge was built.
    const bool remembered =
        law_.laws->ridging && pose.distance < (1.0 + memory_share) * pose.radius_one;
    if (remembered || law_.overlap(pose, history) > 0.0 || history.rest_overlap > 0.0) {
      kept.push_back({face, history});
    }
  });
  if (step > 0.0) near.contacts = std::move(kept);
}

void FixFloeWalls::setup(int vflag) { post_force(vflag); }

void FixFloeWalls::post_force(int) {
  const double step = update->setupflag ? 0.0 : update->dt;
  std::fill(force_.begin(), force_.end(), 0.0);
  for (Near &near : near_) advance(near, step);
}

// The forces of a step act in the next one.
void FixFloeWalls::initial_integrate(int) {
  for (std::size_t k = 0; k < force_.size(); ++k) impulse_[k] += force_[k] * update->dt;
  floe::Ledger &ledger = law_.fix->ledger;
  for (std::size_t k = 0; k < force_.size(); k += 2) {
    ledger.impulse_wall_x += force_[k] * update->dt;
    ledger.impulse_wall_y += force_[k + 1] * update->dt;
  }
  // All faces of a wall move alike.
  int last = -1;
  for (const WallFace &face : faces_) {
    if (face.wall == last) continue;
    last = face.wall;
    work_ += update->dt * (force_[2 * last] * face.v.x + force_[2 * last + 1] * face.v.y);
  }
}

FixFloeWalls::Sums FixFloeWalls::sums(double &max_overlap) {
  Sums out;
  out.work_wall = work_;
  for (const Near &near : near_) {
    each_contact(near, [&](int, const floe::ContactPose &pose, const floe::WallHistory &h) {
      const double overlap = law_.overlap(pose, h);
      if (!(overlap > 0.0)) return;
      out.elastic_wall += law_.energy(near.i, pose, h);
      out.wall_contacts += 1.0;
      max_overlap = std::max(max_overlap, overlap);
    });
  }
  return out;
}

void FixFloeWalls::each_force(const std::function<void(int, Vec2, Vec2)> &visit) const {
  for (const Near &near : near_) {
    each_contact(near, [&](int, const floe::ContactPose &pose, floe::WallHistory h) {
      visit(near.i, pose.d, law_.force(near.i, atom->rmass[near.i], pose, 0.0, h).f);
    });
  }
}

double FixFloeWalls::memory_usage() {
  return static_cast<double>(near_.size() * sizeof(Near) + candidates_.size() * sizeof(int));
}
