// What the camera sees, with the last pose over it; or a photograph that has landed.
import type { ComponentChildren, JSX } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import { Aids } from './aids_view'
import type { Aid } from './live_aids'
import { aheadOf, degrees, ringWords } from './ring_map'
import type { Landed, Session } from './session'

const kLarge_px = 1920

/** Width by height of a picture that is not there yet. */
const kUsualShape = 3 / 2

const shapeOf = (picture: HTMLImageElement): number =>
  picture.naturalWidth / picture.naturalHeight || kUsualShape

/** The picture's own box, as large as the screen lets it be: what lies on it is never beside it. */
function Frame({ shape, children }: { shape: number; children: ComponentChildren }) {
  const style = { '--shape': shape } as JSX.CSSProperties
  return (
    <div class="shoot-picture" style={style}>
      <div class="frame">{children}</div>
    </div>
  )
}

/** Draws each live picture when all of it is there; those that come meanwhile are left out. */
function useLive(frame: number, setShape: (shape: number) => void) {
  const canvas = useRef<HTMLCanvasElement>(null)
  const wanted = useRef(0)
  const busy = useRef(false)
  const [drawn, setDrawn] = useState(0)
  useEffect(() => {
    wanted.current = frame
    const next = async () => {
      if (busy.current || wanted.current === 0) return
      busy.current = true
      const mine = wanted.current
      const image = new Image()
      image.src = api.liveUrl(mine)
      try {
        await image.decode()
        const target = canvas.current
        if (target) {
          target.width = image.naturalWidth
          target.height = image.naturalHeight
          target.getContext('2d', { willReadFrequently: true })!.drawImage(image, 0, 0)
          setShape(shapeOf(image))
          setDrawn(mine)
        }
      } catch {
        // no live picture any more: the last one stays
      }
      busy.current = false
      if (wanted.current !== mine) void next()
    }
    void next()
  }, [frame])
  return { canvas, drawn: frame > 0 ? drawn : 0 }
}

function Onion({ session, share }: { session: Session; share: number }) {
  const [broken, setBroken] = useState('')
  if (!session.onion || session.onion === broken || share === 0) return null
  return (
    <img
      class="onion"
      src={api.landedUrl(session.onion, 0, kLarge_px)}
      alt={`${session.onionPose} from the same angle`}
      style={{ opacity: share }}
      onError={() => setBroken(session.onion)}
    />
  )
}

/** What is seen while no live picture comes. */
function Still({ session, setShape }: { session: Session; setShape: (shape: number) => void }) {
  // Nothing is known yet: neither a picture nor that there will be none.
  if (session.doing === 'begins') return <p class="soft">The camera gets ready …</p>
  const last = session.photographs[session.landed[session.landed.length - 1]]
  if (last)
    return (
      <img
        src={api.landedUrl(last.path, last.version, kLarge_px)}
        alt={`The last photograph, ${last.name}`}
        onLoad={(event) => setShape(shapeOf(event.currentTarget))}
      />
    )
  return <p class="soft">This camera gives no live picture. Photographs show here as they land.</p>
}

export function LiveView(props: {
  session: Session
  onion: number
  aids: Set<Aid>
  children?: ComponentChildren
}) {
  const { session, onion, aids } = props
  const [shape, setShape] = useState(kUsualShape)
  const { canvas, drawn } = useLive(session.frame, setShape)
  const next = aheadOf(session)
  const ahead = next && `Next: ${degrees(next.angle_deg)} of ${ringWords(session.plan, next.ring)}`
  return (
    <Frame shape={shape}>
      <canvas
        ref={canvas}
        role="img"
        aria-label="What the camera sees"
        style={{ display: drawn > 0 ? 'block' : 'none' }}
      />
      {drawn === 0 && <Still session={session} setShape={setShape} />}
      <Onion session={session} share={onion} />
      <Aids on={aids} live={canvas} drawn={drawn} />
      {ahead && <p class="caption-chip number">{ahead}</p>}
      {props.children}
    </Frame>
  )
}

export function LandedView({ one, live }: { one: Landed; live: () => void }) {
  const [shape, setShape] = useState(kUsualShape)
  return (
    <Frame shape={shape}>
      <img
        src={api.landedUrl(one.path, one.version, kLarge_px)}
        alt={one.name}
        onLoad={(event) => setShape(shapeOf(event.currentTarget))}
      />
      <p class="caption-chip number">
        {degrees(one.angle_deg)}, camera at {degrees(one.tilt_deg)} · {one.file}
      </p>
      <button class="back" onClick={live}>
        Back to live <kbd>Esc</kbd>
      </button>
    </Frame>
  )
}

export function OnionSlider(props: {
  session: Session
  share: number
  setShare: (share: number) => void
}) {
  const { session, share } = props
  if (!session.onionPose) return null
  return (
    <label class="shoot-onion">
      <span>
        Over it: <b>{session.onionPose}</b>
      </span>
      <input
        type="range"
        min={0}
        max={100}
        value={Math.round(100 * share)}
        disabled={!session.onion}
        onInput={(event) => props.setShare(Number(event.currentTarget.value) / 100)}
      />
      <span class="number">{session.onion ? `${Math.round(100 * share)} %` : 'not shot'}</span>
    </label>
  )
}
