// Says what the figure is, where photographs do not tell: a click or a line in one of them.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import type { FigureStroke, Photograph, Pose } from '../../api'
import { useKeys } from '../../keys'
import { useStudio } from '../../state'
import { FrameView } from '../../view/frame_view'
import { sentence } from '../../words'
import { askingFor, firstShown, noteOf, pixelsOf, strokeOf } from './figure_model'
import { FigureSide, Refused } from './figure_side'
import { Strip } from './strip'
import type { FigureDesk } from './use_figure'

type Pixel = [number, number]

export interface FigureTool {
  /** what the next click says: this is the figure, or this is not */
  figure: boolean
  /** what was taken for the figure stays bright */
  masks: boolean
}

export function useFigureKeys(
  tool: FigureTool,
  setTool: (tool: FigureTool) => void,
  { strokes }: FigureDesk,
): void {
  useKeys({
    f: () => setTool({ ...tool, figure: true }),
    n: () => setTool({ ...tool, figure: false }),
    m: () => setTool({ ...tool, masks: !tool.masks }),
    'ctrl+z': () => void strokes.undo(),
    'ctrl+shift+z': () => void strokes.redo(),
    'ctrl+y': () => void strokes.redo(),
  })
}

/** Adds what was said, where a step can be told. */
export function said({ figure, strokes }: FigureDesk, stroke: FigureStroke): void {
  if (figure?.step === '') return
  const what = stroke.figure ? 'the figure' : 'not the figure'
  strokes.change(what, [...strokes.clicks, stroke])
}

export function FigureView(props: {
  pose: Pose
  photographs: Photograph[]
  desk: FigureDesk
  /** changes when a step of the pose was made anew */
  results: string
  item: string
  choose: (item: string) => void
}) {
  const { pose, photographs, desk, item, choose } = props
  const [tool, setTool] = useState<FigureTool>({ figure: true, masks: true })
  const { strokes } = desk
  const names = photographs.map((one) => one.name)
  const name = names.includes(item) ? item : firstShown(strokes.clicks, photographs)
  const photograph = photographs.find((one) => one.name === name)
  const go = (by: number) => {
    const next = names[names.indexOf(name) + by]
    if (next) choose(next)
  }
  useFigureKeys(tool, setTool, desk)
  useKeys({
    PageUp: () => go(-1),
    PageDown: () => go(1),
    ',': () => go(-1),
    '.': () => go(1),
  })
  return (
    <div class="figure-bench">
      <div class="figure-main">
        {photograph && (
          <FigureSheet
            key={name}
            pose={pose}
            photograph={photograph}
            tool={tool}
            strokes={strokes.clicks}
            results={props.results}
            add={(stroke) => said(desk, stroke)}
          />
        )}
        <Strip
          src={(one) => api.photoUrl(pose.name, one, 320)}
          label={`Photographs of ${pose.name}`}
          names={names}
          current={name}
          choose={choose}
          note={(one) => noteOf(strokes.clicks, one)}
        />
      </div>
      <FigureSide desk={desk} tool={tool} change={setTool} choose={choose} {...{ name }} />
    </div>
  )
}

/** The sizes that a photograph has before capture has measured it: the browser's. */
function useSize(photograph: Photograph, src: string) {
  const [measured, setMeasured] = useState<{ width: number; height: number } | null>(null)
  const probe = photograph.width === 0 && !measured && (
    <img
      class="hidden"
      alt=""
      src={src}
      onLoad={({ currentTarget: { naturalWidth, naturalHeight } }) =>
        setMeasured({ width: naturalWidth, height: naturalHeight })
      }
    />
  )
  const size = photograph.width > 0 ? photograph : measured
  return { width: size?.width ?? 0, height: size?.height ?? 0, probe }
}

function FigureSheet(props: {
  pose: Pose
  photograph: Photograph
  tool: FigureTool
  strokes: readonly FigureStroke[]
  results: string
  add: (stroke: FigureStroke) => void
}) {
  const { pose, photograph, tool } = props
  const { name } = photograph
  const src = api.photoUrl(pose.name, name, 0, false, photograph.photograph)
  const { width, height, probe } = useSize(photograph, src)
  if (probe || width === 0) return <div class="view empty">Opens {name} … {probe}</div>
  const masked = photograph.captured || photograph.mask_given
  return (
    <StrokeSheet
      picture={name}
      {...{ src, width, height, tool }}
      mask={masked ? api.maskUrl(pose.name, name, 'masks', props.results) : ''}
      label={`${pose.name}: ${name}`}
      kind="Photograph"
      strokes={props.strokes}
      add={props.add}
    />
  )
}

/** A picture with what was said in it, and its mask; clicks and lines say more. */
export function StrokeSheet(props: {
  picture: string
  src: string
  /** '': there is none */
  mask: string
  width: number
  height: number
  label: string
  /** of picture, for people who do not see it */
  kind: string
  tool: FigureTool
  strokes: readonly FigureStroke[]
  add: (stroke: FigureStroke) => void
}) {
  const { picture, width, height, tool } = props
  const [drawn, setDrawn] = useState<Pixel[]>([])
  const here = props.strokes.filter((one) => one.picture === picture && !one.gone)
  const say = (line: Pixel[]) => {
    setDrawn([])
    if (line.length > 0) props.add(strokeOf(picture, line, width, height, tool.figure))
  }
  const wide = Math.max(width, height) / 260
  return (
    <FrameView
      src={props.src}
      width={width}
      height={height}
      label={props.label}
      help={`${props.kind}: the pointer clicks or draws, Space clicks in the middle, the wheel looks closer, Shift and drag move it`}
      caption={picture}
      marks={[]}
      onPick={(pixel) => say([pixel])}
      onChoose={() => undefined}
      onMove={() => undefined}
      onLine={(line, done) => (done ? say(line) : setDrawn([...line]))}
    >
      {tool.masks && props.mask && <Veil src={props.mask} width={width} height={height} />}
      {here.map((stroke, i) => (
        <Said key={i} points={pixelsOf(stroke, width, height)} figure={stroke.figure} wide={wide} />
      ))}
      {drawn.length > 0 && <Said points={drawn} figure={tool.figure} wide={wide} />}
    </FrameView>
  )
}

/** Darkens what was not taken for the figure: the mask is white where the figure is. */
function Veil({ src, width, height }: { src: string; width: number; height: number }) {
  const size = { width, height }
  return (
    <>
      <filter id="figure-inverse" color-interpolation-filters="sRGB">
        <feColorMatrix values="-1 0 0 0 1  0 -1 0 0 1  0 0 -1 0 1  0 0 0 1 0" />
      </filter>
      <mask id="figure-outside" style={{ maskType: 'luminance' }}>
        <image href={src} {...size} preserveAspectRatio="none" filter="url(#figure-inverse)" />
      </mask>
      <rect class="figure-veil" {...size} mask="url(#figure-outside)" />
    </>
  )
}

/** A click, or a line: with a plus where the figure is, with a minus where it is not. */
function Said({ points, figure, wide }: { points: Pixel[]; figure: boolean; wide: number }) {
  const [x, y] = points[points.length >> 1]
  const path = points.map(([px, py], i) => `${i ? 'L' : 'M'}${px} ${py}`).join('')
  const arm = 1.7 * wide
  const sign = `M${x - arm} ${y}h${2 * arm}${figure ? `M${x} ${y - arm}v${2 * arm}` : ''}`
  return (
    <g class={`figure-said ${figure ? 'is' : 'not'}`}>
      {points.length > 1 && <path class="under" d={path} stroke-width={2.4 * wide} />}
      {points.length > 1 && <path class="line" d={path} stroke-width={1.4 * wide} />}
      <circle cx={x} cy={y} r={3.2 * wide} stroke-width={0.7 * wide} />
      <path class="sign" d={sign} stroke-width={0.9 * wide} />
    </g>
  )
}

/** On the photographs' sheet: asks for a click, or says that something was said. */
export function FigureNotice({ desk, open }: { desk: FigureDesk; open: () => void }) {
  const { figure, strokes } = desk
  const { steps } = useStudio()
  if (!figure) return null
  const step = steps.steps.find((one) => one.id === figure.step)
  if (figure.unclear)
    return (
      <section class="older stack" aria-label="What is the figure?">
        <p>
          <b>What is the figure?</b> {askingFor(strokes.clicks)}
        </p>
        <p class="small soft">{sentence(figure.unclear)}</p>
        <Refused figure={figure} />
        <div class="row">
          <button class="main" onClick={open}>
            Show it
          </button>
        </div>
      </section>
    )
  if (strokes.clicks.length === 0 || step?.state === 'done') return null
  return (
    <section class="older row spread" aria-label="What is the figure?">
      <p class="small">
        You have said what the figure is. Its masks are made again at the next run.
      </p>
      <button onClick={open}>Look</button>
    </section>
  )
}
