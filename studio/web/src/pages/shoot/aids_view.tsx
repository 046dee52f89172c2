// Guides, clipping, histogram and loupe over the live picture, each switched on by itself.
import type { RefObject } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'

import { percent } from '../../words'
import { clippingOf, histogramOf, kAids, kBins, sharpnessOf } from './live_aids'
import type { Aid, Histogram } from './live_aids'

const kStored = 'shoot-aids'
/** So many pixels are counted at most: a histogram needs no more. */
const kCounted = 200_000
const kLoupe_px = 48
const kLoupeGain = 4

/** Which are on; the browser remembers it. */
export function useAids(): { on: Set<Aid>; toggle: (aid: Aid) => void } {
  const [on, set] = useState(() => {
    const stored = (localStorage.getItem(kStored) ?? '').split(' ')
    return new Set(kAids.map(([aid]) => aid).filter((aid) => stored.includes(aid)))
  })
  const toggle = (aid: Aid) => {
    const next = new Set(on)
    if (!next.delete(aid)) next.add(aid)
    localStorage.setItem(kStored, [...next].join(' '))
    set(next)
  }
  return { on, toggle }
}

export function AidButtons({ on, toggle }: { on: Set<Aid>; toggle: (aid: Aid) => void }) {
  return (
    <div class="shoot-aids row" role="group" aria-label="Over the live picture">
      {kAids.map(([aid, words, key, about]) => (
        <button
          key={aid}
          class="quiet small"
          title={`${about} (${key.toUpperCase()})`}
          aria-pressed={on.has(aid)}
          aria-keyshortcuts={key}
          onClick={(event) => {
            if (event.detail > 0) event.currentTarget.blur() // the space bar shoots
            toggle(aid)
          }}
        >
          {words}
        </button>
      ))}
    </div>
  )
}

/** @param drawn  another number when the live picture is another one */
export function Aids(props: { on: Set<Aid>; live: RefObject<HTMLCanvasElement>; drawn: number }) {
  const { on, live, drawn } = props
  if (drawn === 0) return null
  return (
    <>
      {on.has('clipping') && <Clipping live={live} drawn={drawn} />}
      {on.has('guides') && <Guides />}
      {on.has('safe') && <SafeFrame />}
      {on.has('loupe') && <Loupe live={live} drawn={drawn} />}
      {on.has('histogram') && <HistogramView live={live} drawn={drawn} />}
    </>
  )
}

const lines = (places: number[]) =>
  places.flatMap((at) => [
    <line key={`x${at}`} x1={at} x2={at} y1={0} y2={100} />,
    <line key={`y${at}`} x1={0} x2={100} y1={at} y2={at} />,
  ])

function Guides() {
  return (
    <svg class="aid lines" viewBox="0 0 100 100" preserveAspectRatio="none" aria-hidden="true">
      {lines([100 / 3, 200 / 3])}
      <g class="middle">{lines([50])}</g>
    </svg>
  )
}

/** Action-safe 93 % and title-safe 90 % of a 16:9 picture (EBU R 95). */
function SafeFrame() {
  const inner = (share: number) => ({ x: 50 - share / 2, y: 50 - share / 2, width: share, height: share })
  return (
    <svg class="aid lines" viewBox="0 0 100 100" preserveAspectRatio="none" aria-hidden="true">
      <rect {...inner(93)} />
      <rect {...inner(90)} class="middle" />
    </svg>
  )
}

interface Seen {
  live: RefObject<HTMLCanvasElement>
  drawn: number
}

function pixelsOf(live: HTMLCanvasElement): ImageData {
  return live.getContext('2d')!.getImageData(0, 0, live.width, live.height)
}

function Clipping({ live, drawn }: Seen) {
  const veil = useRef<HTMLCanvasElement>(null)
  useEffect(() => {
    if (!live.current || !veil.current) return
    const { data, width, height } = pixelsOf(live.current)
    veil.current.width = width
    veil.current.height = height
    veil.current.getContext('2d')!.putImageData(new ImageData(clippingOf(data, width), width, height), 0, 0)
  }, [drawn])
  return <canvas ref={veil} class="aid clipping" aria-hidden="true" />
}

const kColours = ['#ff6b5e', '#6fdc7e', '#6ea8ff']

function HistogramView({ live, drawn }: Seen) {
  const [seen, setSeen] = useState<Histogram | null>(null)
  useEffect(() => {
    if (!live.current) return
    const { data } = pixelsOf(live.current)
    setSeen(histogramOf(data, Math.max(1, Math.ceil(data.length / 4 / kCounted))))
  }, [drawn])
  if (!seen) return null
  // One bin full of a plain backdrop must not flatten the others.
  const top = 4 / kBins
  const path = (shares: number[]) =>
    `M0 40 ${shares.map((share, i) => `L${i} ${40 - 40 * Math.min(1, Math.sqrt(share / top))}`).join(' ')} L${kBins - 1} 40Z`
  return (
    <figure class="aid histogram">
      <svg viewBox={`0 0 ${kBins - 1} 40`} preserveAspectRatio="none" aria-hidden="true">
        {seen.channels.map((shares, i) => (
          <path key={i} d={path(shares)} fill={kColours[i]} />
        ))}
      </svg>
      <figcaption class="number">
        <span class={seen.black > 0.005 ? 'much' : ''}>{percent(seen.black, 1)} black</span>
        <span class={seen.white > 0.005 ? 'much' : ''}>{percent(seen.white, 1)} white</span>
      </figcaption>
    </figure>
  )
}

/** Follows the pointer over the picture; where that is not, the middle is looked at. */
function Loupe({ live, drawn }: Seen) {
  const glass = useRef<HTMLCanvasElement>(null)
  const [at, setAt] = useState({ x: 0.5, y: 0.5 })
  const [sharp, setSharp] = useState(0)
  const best = useRef(0)
  useEffect(() => {
    const frame = live.current?.parentElement
    if (!frame) return
    const move = (event: PointerEvent) => {
      const box = frame.getBoundingClientRect()
      best.current = 0 // of another place
      setAt({
        x: Math.min(1, Math.max(0, (event.clientX - box.left) / box.width)),
        y: Math.min(1, Math.max(0, (event.clientY - box.top) / box.height)),
      })
    }
    frame.addEventListener('pointermove', move)
    return () => frame.removeEventListener('pointermove', move)
  }, [live.current])
  useEffect(() => {
    const from = live.current
    const to = glass.current
    if (!from || !to) return
    const side = Math.min(kLoupe_px, from.width, from.height)
    const x = Math.round(Math.min(from.width - side, Math.max(0, at.x * from.width - side / 2)))
    const y = Math.round(Math.min(from.height - side, Math.max(0, at.y * from.height - side / 2)))
    to.width = to.height = side * kLoupeGain
    const context = to.getContext('2d')!
    context.imageSmoothingEnabled = false
    context.drawImage(from, x, y, side, side, 0, 0, to.width, to.height)
    const part = from.getContext('2d')!.getImageData(x, y, side, side)
    const now = sharpnessOf(part.data, side, side)
    best.current = Math.max(best.current, now)
    setSharp(best.current > 0 ? now / best.current : 0)
  }, [drawn, at])
  const left = at.x < 0.5
  return (
    <figure class={`aid loupe ${left ? 'right' : 'left'}`}>
      <canvas ref={glass} role="img" aria-label="A part of the live picture, four times larger" />
      <figcaption>
        <meter min={0} max={1} value={sharp} aria-label="Sharpness, of the best here" />
        <span class="number">{percent(sharp)} of the sharpest here</span>
      </figcaption>
    </figure>
  )
}
