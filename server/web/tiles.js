// The binary form of changed tiles (server/film/README.md) and what the eye is shown of them. Pure.

/** The value of an IEEE half, for each of its 65,536 bit patterns. */
const half = new Float32Array(65536);
for (let bits = 0; bits < 65536; ++bits) {
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  const size = exponent === 0 ? fraction * 2 ** -24 : exponent === 31 ? (fraction ? NaN : Infinity) : (1 + fraction / 1024) * 2 ** (exponent - 15);
  half[bits] = bits & 0x8000 ? -size : size;
}

/**
 * Reads what GET …/tiles gives: {version, width, height, tiles: [{x, y, width, height, rgba: Uint16Array}]}, where rgba holds
 * halves. Throws an Error if the bytes are not of that form.
 */
export function parseTiles(buffer) {
  const view = new DataView(buffer);
  if (buffer.byteLength < 8 || view.getUint32(0, false) !== 0x54535254) throw new Error('these are no tiles');
  const headerLength = view.getUint32(4, true);
  if (8 + headerLength > buffer.byteLength) throw new Error('the tiles are cut off');
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, headerLength)));
  let offset = 8 + headerLength;
  const tiles = header.tiles.map((tile) => {
    const length = tile.width * tile.height * 4;
    if (offset + 2 * length > buffer.byteLength) throw new Error('the tiles are cut off');
    const rgba = new Uint16Array(buffer, offset, length);
    offset += 2 * length;
    return { ...tile, rgba };
  });
  return { ...header, tiles };
}

/** The sRGB transfer function: linear 0…1 to 0…255, through a table that is fine enough for 8 bits. */
const steps = 8192;
const srgb = new Uint8ClampedArray(steps + 1);
for (let i = 0; i <= steps; ++i) {
  const linear = (i / steps) ** 2; // steps are spaced by the root, as the eye is
  srgb[i] = Math.round(255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055));
}

/** One linear value, already exposed, as a byte. */
export function toByte(linear) {
  if (!(linear > 0)) return 0;
  return linear >= 1 ? 255 : srgb[Math.round(Math.sqrt(linear) * steps)];
}

/**
 * A tile's halves as bytes for a canvas: exposed by `stops`, encoded as sRGB. Colours are premultiplied, a canvas wants them
 * apart from alpha.
 */
export function shown(rgba, stops, bytes) {
  const gain = 2 ** stops;
  for (let i = 0; i < rgba.length; i += 4) {
    const alpha = Math.min(1, Math.max(0, half[rgba[i + 3]]));
    const scale = alpha > 0 ? gain / alpha : 0;
    for (let c = 0; c < 3; ++c) bytes[i + c] = toByte(half[rgba[i + c]] * scale);
    bytes[i + 3] = Math.round(255 * alpha);
  }
  return bytes;
}
