// Poses: their photographs with masks, what was made of them, and how well it fits.
import type { ComponentChildren, ComponentProps } from 'preact'
import { useMemo, useRef, useState } from 'preact/hooks'

import { api } from '../api'
import type { Pose } from '../api'
import { useStudio } from '../state'
import { hasFiles } from '../stray_drops'
import { Chooser } from './new_project/chooser'
import { dropped } from './new_project/files'
import type { Found } from './new_project/files'
import { AddDialog } from './poses/add_dialog'
import { ContactSheet } from './poses/contact_sheet'
import { FigureView } from './poses/figure_view'
import { useFigure } from './poses/use_figure'
import { FitView } from './poses/fit_view'
import { nextByKey } from './poses/keys'
import { resultsOf, useLoaded } from './poses/load'
import { MaskBrush } from './poses/mask_brush'
import { MendView } from './poses/mend_view'
import { PoseSide } from './poses/pose_side'
import { PoseView } from './poses/pose_view'
import './poses/poses.css'
import { judge, ordered } from './poses/quality'
import type { Order } from './poses/quality'
import { usePlace } from './poses/route'
import type { Place } from './poses/route'
import { tabsOf } from './poses/tabs'
import type { Tab } from './poses/tabs'
import { Wipe } from './poses/wipe'

const kTabWords: Record<Tab, string> = {
  photographs: 'Photographs',
  figure: 'Figure',
  '3d': '3D',
  mend: 'Mend',
  fit: 'Fit',
  wipe: 'Wipe',
}

export function PosesPage() {
  const { project } = useStudio()
  const [place, go] = usePlace()
  const pose = project.poses.find((one) => one.name === place.pose) ?? project.poses[0]
  // What is dropped or to be added; empty: a pose without photographs yet.
  const [found, setFound] = useState<Found[] | null>(null)
  const close = (name: string) => {
    setFound(null)
    if (name) go({ pose: name, tab: 'photographs', item: '' })
  }
  return (
    <DropPlace pose={pose?.name ?? ''} take={setFound}>
      {pose ? (
        // The key: nothing of one pose is shown for another while it loads.
        <PosePage
          key={pose.name}
          pose={pose}
          place={{ ...place, pose: pose.name }}
          go={go}
          add={setFound}
        />
      ) : (
        <main class="empty">
          <h1>No poses</h1>
          <p>Drop photographs of a pose here, or make one first.</p>
          <button onClick={() => setFound([])}>New pose …</button>
        </main>
      )}
      {found && <AddDialog found={found} current={pose?.name ?? ''} close={close} />}
    </DropPlace>
  )
}

/** The whole page takes photographs that are dropped anywhere on it. */
function DropPlace(props: {
  pose: string
  take: (found: Found[]) => void
  children: ComponentChildren
}) {
  const [over, setOver] = useState(false)
  const here = (event: DragEvent) => {
    if (!hasFiles(event)) return
    event.preventDefault()
    event.dataTransfer!.dropEffect = 'copy'
    setOver(true)
  }
  const drop = (event: DragEvent) => {
    if (!hasFiles(event)) return
    event.preventDefault()
    setOver(false)
    void dropped(event.dataTransfer!).then((found) => found.length > 0 && props.take(found))
  }
  return (
    <div
      class="drop-place"
      onDragOver={here}
      onDragLeave={(event) => event.relatedTarget === null && setOver(false)}
      onDrop={drop}
    >
      {props.children}
      {over && (
        <div class="drop-here" aria-hidden="true">
          <b>Add to {props.pose || 'a new pose'}</b>
          <span>You are asked before anything is added. Folders can be poses of their own.</span>
        </div>
      )}
    </div>
  )
}

function PosePage(props: {
  pose: Pose
  place: Place
  go: (place: Place) => void
  add: (found: Found[]) => void
}) {
  const { pose, place, go, add } = props
  const { steps, version } = useStudio()
  const results = resultsOf(steps, pose.name)
  const photos = useLoaded(() => api.photos(pose.name), [pose.name, version])
  const judged = useMemo(() => judge(photos.value ?? []), [photos.value])
  const tab = tabsOf(pose).includes(place.tab) ? place.tab : '3d'
  const [order, setOrder] = useState<Order>('name')
  const brushed = useRef('')
  const desk = useFigure(pose.name)
  if (tab === 'photographs' && place.item) brushed.current = place.item
  const open = (item: string) => go({ ...place, tab: 'photographs', item })
  if (tab === 'photographs' && place.item && photos.value)
    return (
      <MaskBrush
        pose={pose}
        judged={ordered(judged, 'name')}
        name={place.item}
        open={open}
        close={() => open('')}
      />
    )
  return (
    <main class="page poses">
      <h1 class="hidden">Pose {pose.name}</h1>
      <PoseSide current={pose} choose={(name) => go({ pose: name, tab, item: '' })} add={() => add([])} />
      <div class="work">
        <Tabs
          pose={pose}
          tab={tab}
          choose={(next) => go({ pose: pose.name, tab: next, item: '' })}
        />
        <div class="panel" role="tabpanel" id="pose-panel" aria-labelledby={`tab-${tab}`}>
          {tab === 'photographs' && (
            <Photographs
              photos={photos}
              {...{ pose, judged, results, open, order, setOrder, cameFrom: brushed.current }}
              desk={desk}
              add={add}
              showFigure={() => go({ pose: pose.name, tab: 'figure', item: '' })}
            />
          )}
          {tab === 'figure' && photos.value && (
            <FigureView
              {...{ pose, desk, results }}
              photographs={ordered(judged, 'name').map((one) => one.photograph)}
              item={place.item}
              choose={(item) => go({ ...place, tab: 'figure', item })}
            />
          )}
          {tab === '3d' && <PoseView pose={pose} results={results} />}
          {tab === 'mend' && <MendView pose={pose} />}
          {tab === 'fit' && <FitView pose={pose} results={results} />}
          {tab === 'wipe' && (
            <Wipe
              pose={pose}
              results={results}
              item={place.item}
              choose={(item) => go({ ...place, tab: 'wipe', item })}
            />
          )}
        </div>
      </div>
    </main>
  )
}

function Photographs(
  props: ComponentProps<typeof ContactSheet> & {
    photos: { value: unknown[] | null; error: string }
  },
) {
  const { photos, ...sheet } = props
  const { pose } = sheet
  if (photos.error) return <div class="empty">{photos.error}</div>
  if (!photos.value) return <div class="empty">Looks through the photographs …</div>
  if (photos.value.length === 0)
    return (
      <div class="empty">
        <h2>No photographs of {pose.name}</h2>
        <p>
          Drop them here, or put them into <code>{pose.photos}</code>; they show at once.
        </p>
        <div class="row">
          <Chooser folder={false} words="Choose files …" add={sheet.add} />
          <Chooser folder words="Choose a folder …" add={sheet.add} />
        </div>
      </div>
    )
  return <ContactSheet {...sheet} />
}

function Tabs({ pose, tab, choose }: { pose: Pose; tab: Tab; choose: (tab: Tab) => void }) {
  const list = useRef<HTMLDivElement>(null)
  const tabs = tabsOf(pose)
  const move = (event: KeyboardEvent) => {
    const next = nextByKey(event, tabs.length, tabs.indexOf(tab), 1)
    if (next === null) return
    event.preventDefault()
    choose(tabs[next])
    list.current!.querySelectorAll('button')[next].focus()
  }
  return (
    <div
      ref={list}
      class="tabs"
      role="tablist"
      aria-label={`Views of ${pose.name}`}
      onKeyDown={move}
    >
      {tabs.map((one) => (
        <button
          key={one}
          id={`tab-${one}`}
          role="tab"
          aria-selected={one === tab}
          aria-controls="pose-panel"
          tabIndex={one === tab ? 0 : -1}
          onClick={() => choose(one)}
        >
          {kTabWords[one]}
          {one === 'photographs' && <span class="number soft">{pose.photographs}</span>}
        </button>
      ))}
    </div>
  )
}
