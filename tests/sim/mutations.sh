#!/bin/sh
# Deliberate bugs in the real code, one at a time in a copy of the tree: the simulation must find each.
#   tests/sim/mutations.sh [FOLDER] [NAME…]   the copy and its build go to FOLDER (build/mutations)
# Prints a table; exit code 1 if one was not found, 2 if one could not be made.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
copy=${1:-$root/build/mutations}
[ $# -gt 0 ] && shift
only=$*
mkdir -p "$copy"

# The files as they are here, changed or not; what is the same keeps its time, and is not built again.
copy_tree() {
  git -C "$root" ls-files --cached --others --exclude-standard | while IFS= read -r file; do
    [ -f "$root/$file" ] || continue
    cmp -s "$root/$file" "$copy/$file" && continue
    mkdir -p "$copy/$(dirname "$file")"
    cp "$root/$file" "$copy/$file"
    touch "$copy/$file"
  done
}

build() { ninja -C "$copy/build/dev" ${JOBS:+-j$JOBS} tessera_sim tessera_sim_store >"$copy/build.log" 2>&1; }

missed=0
mutated=
# mutation NAME FILE SED PROGRAM: the SED script must change FILE; PROGRAM (sim, store) must then fail.
mutation() {
  name=$1 file=$2 script=$3 program=$4
  if [ -n "$only" ]; then
    case " $only " in *" $name "*) ;; *) return 0 ;; esac
  fi
  [ -z "$mutated" ] || cp "$root/$mutated" "$copy/$mutated"
  mutated=$file
  sed -i -E "$script" "$copy/$file"
  if cmp -s "$root/$file" "$copy/$file"; then
    printf '%-34s %-38s could not be made: its place is not found\n' "$name" "$file"
    missed=2
    return 0
  fi
  if ! build; then
    printf '%-34s %-38s does not build: %s/build.log\n' "$name" "$file" "$copy"
    missed=2
    return 0
  fi
  case $program in
    sim) set -- tessera_sim --seeds 1000 ;;
    store) set -- tessera_sim_store --seeds 1500 ;;
  esac
  run=$1
  shift
  code=0
  found=$("$copy/build/dev/bin/$run" "$@" 2>/dev/null) || code=$?
  if [ $code -eq 0 ]; then
    printf '%-34s %-38s NOT FOUND\n' "$name" "$file"
    [ $missed -eq 0 ] && missed=1
    return 0
  fi
  words=$(printf '%s\n' "$found" | grep -m1 '^seed' || echo "ended with code $code")
  printf '%-34s %-38s %s: %s\n' "$name" "$file" "$run" "$(printf '%s' "$words" | cut -c1-160)"
}

copy_tree
(cd "$copy" && cmake --preset dev >/dev/null 2>&1)

# ---- folding ----
mutation double-fold server/coordinator/frame_film.cpp \
  's/^  tile.waiting.erase\(tile.waiting.begin\(\), end\);$/  work.passes.push_back(work.passes.back());\n&/' sim
mutation fold-out-of-order server/coordinator/frame_film.cpp \
  's/^  tile.busy_end = work.passes.back\(\).pass \+ 1;$/&\n  if (count > 1) std::swap(work.passes[0], work.passes[1]);/' sim
mutation pass-left-out-of-the-fold server/film/film_tile.cpp \
  's/^        sums\[i\] \+= n|for \(std::size_t i = 0; i < sums\.size\(\); \+\+i\) sums\[i\] \+= n/if (n != 3) &/' sim
mutation deviations-too-small server/film/film_tile.cpp \
  's/delta \* delta \* weight/0.5 * &/' sim
mutation checkpoint-forgets-where-it-is server/coordinator/frame_film.cpp \
  's/^    tile\.checkpoint = \{checkpoint\.number, kept\.offset, kept\.length\};$//' sim
mutation checkpoint-keeps-what-it-holds server/coordinator/frame_film.cpp \
  's/^    tile\.places\.erase\(tile\.places\.begin\(\), end\);$//' sim
# ---- leases ----
mutation lost-lease server/schedule/workers.cpp \
  's/^  give_back_all\(gone, charge, actions\);$/  if (gone.leases.size() != 2) give_back_all(gone, charge, actions);/' sim
mutation lease-unknown-after-a-restart server/schedule/lease_numbers.cpp \
  's/lease\.epoch > epoch_/lease.epoch != epoch_/' sim
mutation taken-while-being-kept server/schedule/results.cpp \
  's/^  if \(owner->journaling\.contains\(task\)\) return Verdict::stale;$//' sim
mutation restored-closed-task-left-out server/store/index.cpp \
  's/^    visit\(result\);$/    if (result.task.tile % 5 != 3) visit(result);/' sim
# ---- order and time ----
mutation focus-forgotten server/schedule/frame_tasks.cpp \
  's/focus_ \&\& focus_->contains\(task\.tile\) \?/task.pass < 2 \&\& &/' sim
mutation cut-below-what-is-folded server/schedule/time_limit.cpp \
  's/job\.tasks\.cut\(frame, offered\)/job.tasks.cut(frame, std::max(1U, offered - 1))/' sim
mutation passes-offered-too-early server/schedule/time_limit.cpp \
  's/ - twice >= offered/ - 0 * twice >= offered/' sim
# ---- ends by noise ----
mutation noise-end-forgotten-at-the-start server/schedule/jobs.cpp \
  's/^  entry->tasks\.cut\(frame, passes\);$//' sim
mutation another-frame-ended server/schedule/noise_stop.cpp \
  's/state_->cut\(\*owner, frame, actions\)/state_->cut(*owner, owner->plan().spec.frames.first(), actions)/' sim
mutation look-that-found-noise-forgotten server/schedule/noise_stop.cpp \
  's/^    owner->looks\[frame\]\.too_high = passes;$//' sim
# ---- the journal and the database ----
mutation acknowledged-before-the-commit server/store/store.cpp \
  's/^    state_->index\.add_results\(batch, places\);$/    if (places.front().offset % 3 != 1) state_->index.add_results(batch, places);/' store
mutation commit-that-is-none server/store/index.cpp \
  '/for \(const auto& \[key, end\] : ends\) add_segment_/{n;s/transaction\.commit\(\);//}' store
mutation commit-not-synced server/store/index.cpp \
  's/synchronous = FULL/synchronous = NORMAL/' store
mutation no-sync-before-the-commit server/store/journal.cpp \
  's/^    if \(durable_\) file_->sync\(\);$/    if (false) file_->sync();/' store
mutation segment-not-named-durably server/store/journal.cpp \
  's/^      disk_\.sync_folder\(folder_\);$//' store
mutation journal-cut-at-the-wrong-place server/store/journal.cpp \
  's/^    file_->truncate\(end_\);$/    file_->truncate(end_ > 8192 ? end_ - 4096 : end_);/' store
mutation written-over-after-a-failed-commit server/store/store.cpp \
  's/^      state_->journal\.seal\(\);$/      state_->journal.undo();/' store
mutation segment-deleted-too-early server/store/index.cpp \
  's/ON CONFLICT DO UPDATE SET value = value \+ 1"\);/ON CONFLICT DO NOTHING");/' store
mutation log-not-settled-at-the-start server/store/store.cpp \
  's/^  if \(durable\)$/  if (durable \&\& file.empty())/' store
mutation data-folder-not-named-durably server/store/disk.cpp \
  's/^    if \(durable\) disk\.sync_folder\(at\.parent_path\(\)\);$//' store
# ---- checkpoints ----
mutation checkpoint-not-synced server/store/checkpoint_files.cpp \
  's/^    file_->sync\(\);$//' store
mutation checkpoint-not-named-durably server/store/checkpoint_files.cpp \
  's/^    disk_\.sync_folder\(file_->path\(\)\.parent_path\(\)\);$//' store
mutation checkpoint-takes-a-result-too-many server/store/checkpoint_index.cpp \
  's/AND pass < coalesce/AND pass <= coalesce/' store
mutation results-leave-uncounted server/store/checkpoint_index.cpp \
  's/"samples \+ excluded\.samples/"excluded.samples/' store
mutation old-checkpoint-removed-too-early server/store/store.cpp \
  's/^  const auto before = state_->index\.put_checkpoint\(checkpoint\);$/  if (const auto old = state_->index.checkpoint_of(checkpoint.job, checkpoint.frame))\n    state_->checkpoints.remove(old->number);\n&/' store
mutation doubtful-checkpoint-removed server/store/store.cpp \
  's/^  state_->doubtful\.push_back\(checkpoint\.number\);$/  state_->checkpoints.remove(checkpoint.number);/' store
mutation extended-job-keeps-its-last-pass server/store/checkpoint_index.cpp \
  's/WHERE job = \?1 AND pass >= \?2/WHERE job = ?1 AND pass > ?2/' store
mutation forgotten-in-two-commits server/store/checkpoint_index.cpp \
  '/^void Index::forget_job/,/^}/s/^  delete_results\(job\);$/  forget_results(job);/;/^void Index::forget_job/,/^}/s/^  Transaction transaction\(writer_\);$//;/^void Index::forget_job/,/^}/s/^  delete_checkpoints\(job\);$/  Transaction transaction(writer_);\n&/' store
# ---- pictures ----
mutation picture-not-synced server/store/whole_file.cpp \
  's/^    if \(durable\) out->sync\(\);$//' store
mutation rename-not-synced server/store/whole_file.cpp \
  's/^  if \(durable\) disk\.sync_folder\(folder\);$//' store
mutation picture-not-settled-at-the-start server/coordinator/frame_file.cpp \
  's/disk\.sync_folder\(each\);/static_cast<void>(each);/' store

exit $missed
