// By how much two pictures differ: the numbers of `tessera compare` of their files.

/// Width, height and RGBA bytes of a picture.
function pixelsOf(bitmap) {
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height), pen = canvas.getContext("2d");
  pen.drawImage(bitmap, 0, 0);
  return pen.getImageData(0, 0, bitmap.width, bitmap.height);
}

/// { greatest, mean, rmse, unequal, pixels, worst: [x, y] } of two bitmaps, codes divided by 255;
/// null where their sizes differ.
export function difference(one, other) {
  if (one.width !== other.width || one.height !== other.height) return null;
  const a = pixelsOf(one).data, b = pixelsOf(other).data;
  let greatest = 0, sum = 0, squares = 0, unequal = 0, worst = 0;
  for (let at = 0; at < a.length; at += 4) {
    let differs = false;
    for (let channel = at; channel < at + 3; ++channel) {
      const distance = Math.abs(a[channel] - b[channel]);
      if (distance === 0) continue;
      differs = true;
      sum += distance;
      squares += distance * distance;
      if (distance > greatest) [greatest, worst] = [distance, at / 4];
    }
    if (differs) ++unequal;
  }
  const pixels = a.length / 4, numbers = 3 * pixels;
  return { greatest: greatest / 255, mean: sum / numbers / 255, rmse: Math.sqrt(squares / numbers) / 255, unequal, pixels,
           worst: [worst % one.width, Math.floor(worst / one.width)] };
}
