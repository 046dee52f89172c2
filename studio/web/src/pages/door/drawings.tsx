// Small drawings of how to photograph, 200 x 150. Their colours are the page's.
import type { ComponentChildren } from 'preact'

function Drawing({ title, children }: { title: string; children: ComponentChildren }) {
  return (
    <svg viewBox="0 0 200 150" role="img" aria-label={title}>
      {children}
    </svg>
  )
}

/** A clay figure that stands at x, y. */
function Figure({ x, y, size = 1 }: { x: number; y: number; size?: number }) {
  return (
    <g class="draw-clay" transform={`translate(${x} ${y}) scale(${size})`}>
      <path d="M-12 0 C-15 -18 -10 -30 0 -31 C10 -30 15 -18 12 0 L5 0 L3 -8 L-3 -8 L-5 0 Z" />
      <circle cx="0" cy="-40" r="11" />
      <path d="M-8 -48 l-4 -9 l9 4 Z M8 -48 l4 -9 l-9 4 Z" />
      <path d="M-11 -24 q-10 2 -12 12 l5 1 q2 -7 8 -7 Z M11 -24 q10 2 12 12 l-5 1 q-2 -7 -8 -7 Z" />
    </g>
  )
}

function Camera({ x, y, turn = 0 }: { x: number; y: number; turn?: number }) {
  return (
    <g class="draw-dark" transform={`translate(${x} ${y}) rotate(${turn})`}>
      <rect x="-13" y="-8" width="20" height="16" rx="2" />
      <rect x="7" y="-5" width="8" height="10" rx="1" />
    </g>
  )
}

const Table = ({ y = 122 }: { y?: number }) => (
  <rect class="draw-table" x="10" y={y} width="180" height="6" rx="2" />
)

function Lamp({ x, flip }: { x: number; flip?: boolean }) {
  return (
    <g transform={`translate(${x} 42) scale(${flip ? -1 : 1} 1)`}>
      <rect class="draw-light" x="6" y="-22" width="9" height="44" rx="3" />
      <path class="draw-line" d="M4 0 L-6 0 L-6 80" />
      <path class="draw-soft" d="M20 -12 L44 0 M20 4 L44 12 M20 20 L40 24" />
    </g>
  )
}

export const LightDrawing = () => (
  <Drawing title="Two large soft lamps, left and right of the figure">
    <Table />
    <Figure x={100} y={122} size={1.2} />
    <Lamp x={26} />
    <Lamp x={174} flip />
  </Drawing>
)

export const RingsDrawing = () => (
  <Drawing title="The camera on a tripod at the figure's eye height, and again from 30 degrees above">
    <Table y={128} />
    <rect class="draw-shade" x="118" y="122" width="56" height="6" rx="3" />
    <Figure x={146} y={122} />
    <path class="draw-soft" d="M52 88 L132 88 M60 34 L134 82" />
    <Camera x={34} y={88} />
    <Camera x={44} y={24} turn={31} />
    <path class="draw-line" d="M32 97 L32 128 M32 104 L20 128 M32 104 L44 128" />
    <path class="draw-line" d="M124 136 q22 9 44 0 m-7 -3 l7 3 l-4 7" />
  </Drawing>
)

const kShots = Array.from({ length: 24 }, (_, i) => (Math.PI * i) / 12)

export const StepsDrawing = () => (
  <Drawing title="From above: 24 photographs, evenly round the figure">
    <circle class="draw-soft" cx="100" cy="75" r="58" />
    {kShots.map((angle) => (
      <circle
        key={angle}
        class="draw-dark"
        cx={100 + 58 * Math.cos(angle)}
        cy={75 + 58 * Math.sin(angle)}
        r="3.4"
      />
    ))}
    <ellipse class="draw-clay" cx="100" cy="75" rx="20" ry="15" />
    <path class="draw-line" d="M100 75 L158 75 M100 75 L156 60" />
    <text class="draw-words" x="122" y="92">
      15°
    </text>
  </Drawing>
)

export const BackdropDrawing = () => (
  <Drawing title="A plain, matt backdrop of another colour than the figure, far behind it">
    <path
      class="draw-table"
      d="M24 14 L176 14 L176 96 Q176 122 190 128 L10 128 Q24 122 24 96 Z"
    />
    <rect class="draw-shade" x="66" y="122" width="68" height="6" rx="3" />
    <Figure x={100} y={122} size={1.35} />
  </Drawing>
)

export const MatDrawing = () => (
  <Drawing title="The figure stands on a printed mat of squares, which turns with it">
    <g transform="translate(100 112) scale(1 0.36)">
      <g transform="rotate(30)">
        {Array.from({ length: 36 }, (_, i) => (
          <rect
            key={i}
            class={(i + Math.floor(i / 6)) % 2 === 0 ? 'draw-dark' : 'draw-paper'}
            x={-66 + 22 * (i % 6)}
            y={-66 + 22 * Math.floor(i / 6)}
            width="22"
            height="22"
            fill="#fffefb"
          />
        ))}
      </g>
    </g>
    <Figure x={100} y={112} size={1.3} />
  </Drawing>
)

export const FrameDrawing = () => (
  <Drawing title="The whole figure fills two thirds of the frame's height">
    <rect class="draw-line" x="34" y="18" width="132" height="104" rx="3" />
    <Figure x={100} y={106} size={1.35} />
    <path class="draw-line" d="M182 30 L182 106 M178 34 L182 30 L186 34 M178 102 L182 106 L186 102" />
    <text class="draw-words" x="172" y="134">
      2/3
    </text>
  </Drawing>
)
