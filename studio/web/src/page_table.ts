// The one list of the studio's pages, in the order in which the bar at the top shows them.
import type { FunctionComponent } from 'preact'

import type { Project } from './api'
import { ArmaturePage } from './pages/armature'
import { CamerasPage } from './pages/cameras'
import { ExportPage } from './pages/export'
import { FilmsPage } from './pages/films'
import { LandmarksPage } from './pages/landmarks'
import { MarksPage } from './pages/marks'
import { MotionPage } from './pages/motion'
import { NewProjectPage } from './pages/new_project'
import { PosesPage } from './pages/poses'
import { ReviewPage } from './pages/review'
import { RunPage } from './pages/run'
import { ShootPage } from './pages/shoot'
import { ShotPage } from './pages/shot'
import { TimelinePage } from './pages/timeline'

/** takes: of a puppet alone, no pose was photographed. A performance has neither poses nor keys. */
type Kind = 'poses' | 'performance' | 'takes'

export interface Page {
  /** in the address; pages/PATH.tsx has the page */
  path: string
  name: string
  page: FunctionComponent
  /** the projects that have it */
  of: Kind[]
  /** those that begin with it */
  first?: Kind
  /** shown while pipeline.yaml has a mistake, too */
  needsNoPlan?: boolean
  /** what stands in its place in a folder without a project: a way to fill it */
  early?: { name: string; page: FunctionComponent }
}

export const kPages: Page[] = [
  {
    path: 'shoot',
    name: 'Shoot',
    page: ShootPage,
    of: ['poses'],
    early: { name: 'Shoot', page: ShootPage },
  },
  {
    path: 'poses',
    name: 'Poses',
    page: PosesPage,
    of: ['poses'],
    first: 'poses',
    early: { name: 'From files', page: NewProjectPage },
  },
  { path: 'cameras', name: 'Cameras', page: CamerasPage, of: ['performance'], needsNoPlan: true },
  { path: 'films', name: 'Films', page: FilmsPage, of: ['performance'], first: 'performance' },
  { path: 'marks', name: 'Marks', page: MarksPage, of: ['performance'] },
  { path: 'motion', name: 'Motion', page: MotionPage, of: ['performance'] },
  {
    path: 'run',
    name: 'Run',
    page: RunPage,
    of: ['poses', 'performance', 'takes'],
    first: 'takes',
  },
  { path: 'landmarks', name: 'Landmarks', page: LandmarksPage, of: ['poses'] },
  { path: 'timeline', name: 'Timeline', page: TimelinePage, of: ['poses'] },
  { path: 'shot', name: 'Shot', page: ShotPage, of: ['poses'] },
  {
    path: 'armature',
    name: 'Armature',
    page: ArmaturePage,
    of: ['poses', 'takes'],
    early: { name: 'Armature', page: ArmaturePage },
  },
  { path: 'review', name: 'Review', page: ReviewPage, of: ['poses', 'performance', 'takes'] },
  {
    path: 'export',
    name: 'Report & export',
    page: ExportPage,
    of: ['poses', 'performance', 'takes'],
  },
]

function kindOf(project: Project): Kind {
  if (project.kind === 'performance') return 'performance'
  const takesOnly = project.poses.length === 0 && !project.empty && project.problem === ''
  return takesOnly ? 'takes' : 'poses'
}

export const pagesOf = (project: Project): Page[] =>
  kPages.filter((one) => one.of.includes(kindOf(project)))

/** The page of this name, or the one that the project begins with. */
export function pageAt(project: Project, path: string): Page {
  const pages = pagesOf(project)
  return (
    pages.find((one) => one.path === path) ??
    pages.find((one) => one.first === kindOf(project)) ??
    pages[0]
  )
}
