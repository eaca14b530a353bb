#pragma once

namespace tessera::sim {

/// Mistakes that can be built in, to see that the audit finds them.
enum class Bug {
  none,
  fold_out_of_order,
  double_fold,
  acknowledge_before_commit,
  keep_without_asking,  // take results without the scheduler's verdict
  forget_lost_worker,   // a lost connection is not told to the scheduler, and the worker counts as
                        // heard
  ignore_fold_limit,    // tells the scheduler of folds that have not happened
};

}  // namespace tessera::sim
