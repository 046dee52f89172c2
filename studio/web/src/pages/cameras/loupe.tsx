// What lies under the pointer, four times as large, so that a place is clicked to the pixel.

const kTimes = 4
const kSide_px = 176

export function Loupe(props: {
  src: string
  width: number
  height: number
  /** of the picture, under the pointer */
  pixel: [number, number]
}) {
  const [x, y] = props.pixel
  // On the other side of the picture than what is looked at.
  const side = x < props.width / 2 ? 'right' : 'left'
  return (
    <div
      class={`cam-loupe ${side}`}
      aria-hidden="true"
      style={{
        width: `${kSide_px}px`,
        height: `${kSide_px}px`,
        backgroundImage: `url("${props.src}")`,
        backgroundSize: `${props.width * kTimes}px ${props.height * kTimes}px`,
        backgroundPosition: `${kSide_px / 2 - x * kTimes}px ${kSide_px / 2 - y * kTimes}px`,
      }}
    >
      <span class="number">
        {x.toFixed(1)}, {y.toFixed(1)}
      </span>
    </div>
  )
}
