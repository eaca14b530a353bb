#pragma once

namespace tessera::render {

/// What AOVs call an object or a material; 0: nothing.
struct Identity {
  float number = 0;  ///< from 1, in the order in which the scene has their names
  float matte = 0;   ///< matte_id()
};

}  // namespace tessera::render
