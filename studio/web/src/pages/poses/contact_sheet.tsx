// All photographs of a pose, with what capture measured; choosing one opens the brush.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { Pose } from '../../api'
import { Menu, placeOfMenu } from '../../menu'
import type { MenuItem, MenuPlace } from '../../menu'
import { Picture } from '../../picture'
import { useStudio } from '../../state'
import { count, percent } from '../../words'
import { Chooser } from '../new_project/chooser'
import type { Found } from '../new_project/files'
import { FigureNotice } from './figure_view'
import { Flags } from './flags'
import { nextByKey } from './keys'
import { drawVeil } from './mask_picture'
import { OlderMasks } from './older_masks'
import { usePhotoActs } from './photo_acts'
import type { PhotoActs } from './photo_acts'
import { ordered, signedPercent } from './quality'
import type { Judged, Order } from './quality'
import type { FigureDesk } from './use_figure'
import { saidOf, Warnings } from './warnings'

export function ContactSheet(props: {
  pose: Pose
  judged: Judged[]
  results: string
  open: (name: string) => void
  order: Order
  setOrder: (order: Order) => void
  /** the photograph that was under the brush, or '' */
  cameFrom: string
  desk: FigureDesk
  showFigure: () => void
  /** photographs that were chosen, to be added */
  add: (found: Found[]) => void
}) {
  const { steps } = useStudio()
  const acts = usePhotoActs(props.pose.name)
  const [wanted, show] = useState<{ name: string } | null>(null)
  const { order, setOrder } = props
  const [veiled, setVeiled] = useState(true)
  const shown = useMemo(() => ordered(props.judged, order), [props.judged, order])
  const used = props.judged
    .filter((one) => !one.photograph.left_out)
    .map((one) => one.photograph.name)
  return (
    <>
      <div class="tools row">
        <p class="soft small">{summaryOf(props.judged)}</p>
        <div class="row end">
          <Chooser folder={false} words="Add …" label="Add photographs" add={props.add} />
          <button aria-pressed={veiled} onClick={() => setVeiled(!veiled)}>
            Masks
          </button>
          <div class="choice" role="group" aria-label="Order">
            <button aria-pressed={order === 'name'} onClick={() => setOrder('name')}>
              By name
            </button>
            <button aria-pressed={order === 'worst'} onClick={() => setOrder('worst')}>
              Worst first
            </button>
          </div>
        </div>
      </div>
      <div class="scroll">
        <FigureNotice desk={props.desk} open={props.showFigure} />
        <OlderMasks
          pose={props.pose.name}
          names={shown
            .filter((one) => one.photograph.mask_of_another)
            .map((one) => one.photograph.name)}
        />
        <Warnings
          said={saidOf(steps, props.pose.name, used)}
          judged={props.judged}
          acts={acts}
          show={(name) => show({ name })}
        />
        <Grid {...props} {...{ shown, veiled, acts, wanted }} />
        {acts.chooser}
      </div>
    </>
  )
}

function summaryOf(judged: Judged[]): string {
  const having = (text: string) =>
    judged.filter((one) => one.flags.some((flag) => flag.text === text)).length
  const parts = [count(judged.length, 'photograph')]
  const out = judged.filter((one) => one.photograph.left_out).length
  const strange = judged.filter(
    (one) => one.photograph.another_thing && !one.photograph.left_out,
  ).length
  const waiting =
    judged.filter((one) => !one.photograph.captured && !one.photograph.left_out).length - strange
  const given = judged.filter((one) => one.photograph.mask_given).length
  const dark = having('dark') + having('bright')
  if (out > 0) parts.push(`${out} left out`)
  if (waiting > 0) parts.push(`${waiting} not captured yet`)
  if (strange > 0) parts.push(`${strange} of another thing`)
  if (having('no figure') > 0) parts.push(`${having('no figure')} without a figure`)
  if (having('mask') > 0) parts.push(`${count(having('mask'), 'mask')} to look at`)
  if (having('blurred') > 0) parts.push(`${having('blurred')} blurred`)
  if (dark > 0) parts.push(`${dark} off in exposure`)
  if (given > 0) parts.push(`${given} with a mask of your own`)
  return parts.join(' · ')
}

function Grid(props: {
  pose: Pose
  shown: Judged[]
  veiled: boolean
  results: string
  open: (name: string) => void
  cameFrom: string
  acts: PhotoActs
  /** to be shown, because a warning names it */
  wanted: { name: string } | null
}) {
  const { acts } = props
  const [menu, setMenu] = useState<{ name: string; place: MenuPlace } | null>(null)
  const list = useRef<HTMLUListElement>(null)
  const names = props.shown.map((one) => one.photograph.name)
  const [current, setCurrent] = useState(() => Math.max(0, names.indexOf(props.cameFrom)))
  useEffect(() => {
    if (props.cameFrom) tilesOf(list.current!)[current]?.focus()
  }, [])
  useEffect(() => {
    const at = props.wanted ? names.indexOf(props.wanted.name) : -1
    if (at < 0) return
    setCurrent(at)
    const tile = tilesOf(list.current!)[at]
    tile.scrollIntoView({ block: 'center' })
    tile.focus()
  }, [props.wanted])
  const act = (event: KeyboardEvent, at: number): boolean => {
    const one = props.shown[at]?.photograph
    if (!one || event.ctrlKey || event.metaKey || event.altKey) return false
    if (event.key === 'Delete') acts.remove([one.name])
    else if (event.key === 'o') acts.leaveOut([one.name], !one.left_out)
    else if (event.key === 'r') acts.replace(one.name)
    else return false
    event.preventDefault()
    return true
  }
  const move = (event: KeyboardEvent) => {
    const buttons = tilesOf(list.current!)
    const at = buttons.indexOf(event.target as HTMLButtonElement)
    if (at < 0 || act(event, at)) return
    const next = nextByKey(event, buttons.length, at, columnsOf(buttons))
    if (next === null) return
    event.preventDefault()
    setCurrent(next)
    buttons[next].focus()
  }
  const asked = props.shown.find((one) => one.photograph.name === menu?.name)
  return (
    <>
    <ul
      ref={list}
      class={`sheet ${props.veiled ? 'veiled' : ''}`}
      aria-label={`Photographs of ${props.pose.name}`}
      onKeyDown={move}
    >
      {props.shown.map((one, i) => (
        <Tile
          key={one.photograph.name}
          pose={props.pose.name}
          judged={one}
          results={props.results}
          reached={i === Math.min(current, props.shown.length - 1)}
          open={() => props.open(one.photograph.name)}
          ask={(event) => {
            event.preventDefault()
            setMenu({ name: one.photograph.name, place: placeOfMenu(event) })
          }}
        />
      ))}
    </ul>
      {menu && asked && (
        <Menu
          label={`What to do with ${menu.name}`}
          items={itemsOf(asked, acts, () => props.open(menu.name))}
          note={acts.note}
          place={menu.place}
          close={() => setMenu(null)}
        />
      )}
    </>
  )
}

const tilesOf = (list: HTMLElement) => [...list.querySelectorAll<HTMLButtonElement>('.tile')]

function itemsOf({ photograph }: Judged, acts: PhotoActs, open: () => void): MenuItem[] {
  const { name, left_out: out } = photograph
  return [
    { words: 'Look closer, mend its mask', keys: '⏎', act: open },
    {
      words: out ? 'Take it back' : 'Leave it out',
      keys: 'O',
      act: () => acts.leaveOut([name], !out),
    },
    { words: 'Replace it …', keys: 'R', act: () => acts.replace(name) },
    { words: 'Delete, to the bin', keys: 'Del', act: () => acts.remove([name]) },
  ]
}

/** How many tiles the browser has put into the first row. */
function columnsOf(buttons: HTMLElement[]): number {
  const tops = buttons.map((one) => one.getBoundingClientRect().top)
  const second = tops.findIndex((top) => top !== tops[0])
  return second < 0 ? buttons.length : second
}

function Tile(props: {
  pose: string
  judged: Judged
  results: string
  reached: boolean
  open: () => void
  /** opens the menu */
  ask: (event: MouseEvent) => void
}) {
  const { judged, pose } = props
  const { photograph } = judged
  const veil = useVeil(pose, judged, props.results)
  const shape = photograph.width ? `${photograph.width} / ${photograph.height}` : '4 / 3'
  return (
    <li class={photograph.left_out ? 'out' : ''}>
      <button
        class="tile"
        tabIndex={props.reached ? 0 : -1}
        onClick={props.open}
        onContextMenu={props.ask}
      >
        <span class="thumb" style={{ aspectRatio: shape }}>
          <Picture
            src={api.photoUrl(pose, photograph.name, 320, false, photograph.photograph)}
            alt=""
            loading="lazy"
          />
          <canvas ref={veil} width={1} height={1} />
          {judged.flags.length > 0 && (
            <span class="marks">
              <Flags judged={judged} />
            </span>
          )}
        </span>
        <span class="caption">
          <span class="name">{photograph.name}</span>
          {photograph.mask_given && (
            <span class="given" title="This mask is your own">
              own mask
            </span>
          )}
          {photograph.mask_of_another && (
            <span class="given" title="Your mask is of an older photograph: it is not used">
              older mask
            </span>
          )}
        </span>
        <Figures judged={judged} />
      </button>
      <button
        class="more"
        tabIndex={-1}
        aria-haspopup="menu"
        aria-label={`What to do with ${photograph.name}`}
        onClick={props.ask}
      >
        ⋯
      </button>
    </li>
  )
}

function Figures({ judged }: { judged: Judged }) {
  if (judged.photograph.left_out) return <span class="figures">left out: no step reads it</span>
  if (judged.photograph.another_thing) return <span class="figures">shows another thing</span>
  if (!judged.photograph.captured) return <span class="figures">not captured yet</span>
  const has = (...texts: string[]) => judged.flags.find((flag) => texts.includes(flag.text))
  return (
    <span class="figures number">
      <span class={has('blurred')?.grade} title="Sharpness, against the middle of the set">
        <span class="hidden">sharpness </span>
        <i aria-hidden="true">◎</i> {percent(judged.sharpness)}
      </span>
      <span class={has('dark', 'bright')?.grade} title="Exposure, against the middle of the set">
        <span class="hidden">exposure </span>
        <i aria-hidden="true">☀</i> {signedPercent(judged.exposure)}
      </span>
    </span>
  )
}

/** Draws the mask when the tile comes near the window, and again when the pose was made anew. */
function useVeil(pose: string, judged: Judged, results: string) {
  const canvas = useRef<HTMLCanvasElement>(null)
  const { name, captured, mask_given: given, photograph } = judged.photograph
  useEffect(() => {
    if (!captured && !given) {
      canvas.current!.width = canvas.current!.height = 1 // that of an older photograph
      return
    }
    let wanted = true
    const observer = new IntersectionObserver(
      (entries) => {
        if (!entries.some((one) => one.isIntersecting)) return
        observer.disconnect()
        void drawVeil(canvas.current!, pose, name, () => wanted)
      },
      { rootMargin: '200px' },
    )
    observer.observe(canvas.current!)
    return () => {
      wanted = false
      observer.disconnect()
    }
  }, [pose, name, captured, given, photograph, results])
  return canvas
}
