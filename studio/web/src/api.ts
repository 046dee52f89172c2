// The studio's server, as the page sees it. docs/studio-api.md describes each request.

/** The sound that the animation is timed to. */
export interface ProjectSound {
  /** its path in the project */
  file: string
  name: string
  /** when it begins on the timeline [s] */
  at: number
}

/** A request that the server refused, with the words that it gave. */
export class ApiError extends Error {
  constructor(
    readonly status: number,
    message: string,
  ) {
    super(message)
  }
}

/** What kind of end a step's last result or plan has. */
export type StepState = 'done' | 'would_run' | 'waits' | 'failed' | 'never' | 'missing'

export interface Pose {
  name: string
  template: boolean
  /** 'fit': from few photographs, which the template is bent into; it has no scan */
  method: 'scan' | 'fit'
  photos: string
  /** number of photographs in the pose's folder */
  photographs: number
  /** how many of them no step reads */
  left_out: number
  /** the folder of masks that the project names, or '' */
  masks: string
  /** the mesh made elsewhere that the project names, or '' */
  mesh: string
  has_landmarks: boolean
  /** which meshes exist by now: 'mesh', 'clean', 'refined', 'surface', 'cloud' */
  meshes: string[]
  has_texture: boolean
  /** how well photographs show the texture */
  has_confidence: boolean
  has_cameras: boolean
  /** of a performance's shot: its moving mesh is there */
  has_frames: boolean
}

export interface Project {
  name: string
  folder: string
  /** of a performance the poses are its shots */
  kind: 'poses' | 'performance'
  poses: Pose[]
  template: string
  fps: number
  /** hash of pipeline.yaml; sent back with each change */
  revision: string
  /** what is wrong with pipeline.yaml, or '' */
  problem: string
  has_frames: boolean
  has_report: boolean
  /** whether pipeline.yaml has a filmed shot */
  has_shot: boolean
  /** true: no pipeline.yaml in the folder yet */
  empty: boolean
}

/** A picture that a step left when it failed. */
export interface FailurePicture {
  step: string
  picture: string
  /** another failure has another one */
  version: string
}

export interface Step {
  id: string
  step: string
  stage: string
  /** what an artist calls its work, as the stage says of itself */
  title: string
  pose: string
  state: StepState
  /** of the last success [s]; 0: none */
  seconds: number
  reasons: string[]
  waits_for: string[]
  error: string
  exit_code: number
  /** that it left when it failed, to show why */
  pictures: FailurePicture[]
  /** as used, text by option */
  options: Record<string, string>
  /** the options that pipeline.yaml sets, by name, with their line */
  set: Record<string, { text: string; line: number; pose: boolean }>
}

export interface Warning {
  steps: string[]
  poses: string[]
  text: string
}
export interface Verdict {
  about: string
  grade: 'good' | 'look' | 'wrong'
  why: string
  step: string
}

export interface Steps {
  steps: Step[]
  warnings: Warning[]
  /** of steps that will run again, when they ran last */
  earlier_warnings: Warning[]
  verdicts: Verdict[]
  /** a run that the studio started */
  running: boolean
  /** words on who else holds the project's lock, or '' */
  locked_by: string
}

export interface StageOption {
  name: string
  type: 'bool' | 'int' | 'double' | 'string'
  default: string
  unit: string
  help: string
  min?: number
  max?: number
  choices?: string[]
}
export interface Stage {
  stage: string
  summary: string
  options: StageOption[]
}

export interface Photograph {
  name: string
  width: number
  height: number
  sharpness: number
  exposure: number
  mask_fraction: number
  mask_given: boolean
  /** one's own mask is there, but of an older photograph of this name: it is not used */
  mask_of_another: boolean
  /** SHA-256 of its file: another one after it was shot again */
  photograph: string
  trusted: boolean
  why: string
  /** capture has left it out, as `why` says */
  another_thing: boolean
  /** false: in the folder, but capture has not made it yet, or an older one of this name */
  captured: boolean
  /** a person leaves it out: no step reads it */
  left_out: boolean
}

/** A path of the brush that mends a mesh. */
export interface MendStroke {
  tool: 'smooth' | 'pull' | 'fill'
  /** in the mesh's unit */
  radius: number
  /** 0 to 1; of pull from -1, into the figure */
  strength: number
  places: { face: number; barycentric: [number, number, number] }[]
  /** why it does not lie on the mesh any more, or '' */
  fault: string
}

/** See studio/project/mending.h. */
export interface Mending {
  revision: string
  problem: string
  /** changes when the mesh under the strokes does */
  mesh: string
  strokes: MendStroke[]
  again: Again
}

/** What runs again when a pose's photographs change. */
export interface Again {
  /** '': nothing reads them */
  step: string
  /** ids of the steps after it */
  follow: string[]
  /** that all of them took last */
  seconds: number
  /** false: nothing was made of the pose yet */
  made: boolean
}

/** Something that was deleted on these pages. */
export interface BinEntry {
  id: string
  what: 'photographs' | 'pose' | 'files'
  pose: string
  /** of photographs */
  names: string[]
  /** as they lay in the project */
  files: string[]
}

export interface CameraView {
  name: string
  /** world_from_camera, row-major 3 x 4: x right, y down, z forward */
  pose: number[]
  focal_px: number
  width: number
  height: number
  /** principal point [px] */
  cx: number
  cy: number
}

export interface Pick {
  name: string
  face: number
  barycentric: [number, number, number]
}
/**
 * What a person said the figure is, or is not: a click or a line in a photograph, or in a frame of a
 * shot's films.
 */
export interface FigureStroke {
  /** as pipeline.yaml has it; '' until it is saved */
  text: string
  /** of a shot CAMERA/FRAME */
  picture: string
  /** false: what lies there is not the figure */
  figure: boolean
  /** shares of the photograph's width and height, as it is shown */
  points: [number, number][]
  /** its photograph is not there any more */
  gone: boolean
}
export interface Figure {
  /** of pipeline.yaml */
  revision: string
  /** that is told, such as masks/rest; '' if none can be */
  step: string
  /** why none can be, or what is wrong with the text in pipeline.yaml; or '' */
  problem: string
  /** the words of a step that asks what the figure is, or '' */
  unclear: string
  /** the picture of all masks, below out/; or '' */
  sheet: string
  /** pictures of what was taken for the figure when a step last refused it */
  refused: FailurePicture[]
  /** ids of the steps that run again after it if its result changes */
  follow: string[]
  strokes: FigureStroke[]
}

/** The films of a performance's shot. */
export interface Films {
  /** why there are none to show, or '' */
  problem: string
  /** masked: each frame has a mask */
  cameras: { name: string; frames: number; width: number; height: number; masked: boolean }[]
}

/** A place in a photograph of a pose from few photographs. */
export interface PhotoPick {
  name: string
  image: string
  /** of the full size, from its upper left corner */
  pixel: [number, number]
  /** SHA-256 of the one that was picked in, where it is known; absent: the one that is shown */
  photograph?: string
}
export interface Picks {
  pose: string
  /** '': no file yet */
  revision: string
  picks: Pick[]
  /** of a pose from few photographs, which has no mesh to pick on */
  pixels?: PhotoPick[]
  /** what is wrong with single picks, by name */
  problems: { name: string; text: string }[]
}

/** What is known of picks in a pose's photographs; all but `photographs` from the last fit. */
export interface PhotoFit {
  photographs: {
    name: string
    width: number
    height: number
    /** SHA-256 of it as captured */
    photograph: string
    /** a newer one is there, which capture has not read yet */
    shot_again: boolean
    /** its camera is known */
    placed: boolean
    /** overlap of fitted model and mask; null: no fit yet */
    iou: number | null
    /** where their outlines are farthest apart */
    worst: { pixel: [number, number]; distance_px: number; beyond: 'model' | 'mask' } | null
  }[]
  /** where the fitted model has each of the template's picks; hidden: behind another part */
  shown: (PhotoPick & { hidden: boolean })[]
  /** where a name that was picked in one photograph may lie in others */
  lines: { name: string; image: string; points: [number, number][] }[]
  /** where a name that was picked in two or more must lie in each */
  meets: PhotoPick[]
  refused: { name: string; image: string }[]
}

export interface Suggestion {
  name: string
  source: Pick
  target: Pick
  confidence: number
}
/** A landmark of one half of the template, on its other half; see studio/project/mirrored_picks.h. */
export interface Mirrored {
  of: string
  source: Omit<Pick, 'name'>
  target: Omit<Pick, 'name'> | null
  off: number
}
export interface Advice {
  /** a vertex of the template where one more landmark would help */
  vertex: number
  place: [number, number, number]
  need: number
}

export interface TimelineKey {
  pose: string
  at: number
  hold?: number
  ease?: string | number[]
}
export interface Timeline {
  revision: string
  /** false: the file only gives the order of poses, and the times are those of the next frames */
  timed: boolean
  fps: number
  keys: TimelineKey[]
  loop: boolean
  /** frames for which each picture stays: 1, 2 or 3 */
  step: number
  /** fields that the page does not edit, kept as they are */
  other: Record<string, unknown>
}

/** The colours that a performance's shot can be shown in. */
export interface FrameColours {
  /** a texture, colours of the vertices, or none */
  own: 'texture' | 'vertices' | ''
  /** why there are none, and what to do; or '' */
  own_problem: string
  /** a texture for each frame; null: none */
  video: { width: number; height: number; version: string } | null
  video_problem: string
}

export interface Frames {
  count: number
  fps: number
  vertices: number
  /** relative to the first key, per frame */
  area: number[]
  volume: number[]
  linear_area: number[]
  linear_volume: number[]
  /** the pose that a frame shows exactly, or '' */
  keys: string[]
  /** per frame: number of the key plus share of the way to the next; empty if not known */
  times: number[]
  /** per key: its pose */
  poses: string[]
  /** of a performance's shot; null for the animation */
  colours: FrameColours | null
}

/** As the flags of `keypose shoot` say. */
export interface ShootSetup {
  pose: string
  /** "gphoto2", "folder:PATH", "simulated", "simulated:PATH" */
  camera: string
  /** "none", "grbl:DEV", "steps:DEV", "simulated" */
  turntable: string
  /** heights of the camera above the table [degrees] */
  rings: number[]
  angles: number
  /** how often the figure is laid on another side */
  flips: number
  /** flags that few need, as `keypose shoot` calls them */
  more?: Record<string, string>
}
export interface ShootStory {
  running: boolean
  /** of the last event */
  number: number
  /** docs/shoot.md describes them */
  events: ShootEvent[]
  exit_code: number
  /** what the last session said when it failed, or '' */
  message: string
  /** serial ports for a turntable */
  ports: { path: string; name: string }[]
  /** with which poses were begun, by the pose's name; a pose keeps its plan */
  plans: Record<string, { rings_deg?: number[]; angles?: number; flips?: number }>
  /** of the last session in this project */
  setup: ShootSetup | null
}
/** One line of `keypose shoot --commands`. */
export interface ShootEvent {
  event: string
  [key: string]: unknown
}

/** Of the project that this tab shows, as the server names it. */
let shownProject = ''
const kProjectHeader = 'X-Keypose-Project'
const kMoved = 'another-project'

/** Whether another tab has opened another project, which this one therefore shows; told once. */
export function wasMoved(): boolean {
  const moved = sessionStorage.getItem(kMoved) !== null
  sessionStorage.removeItem(kMoved)
  return moved
}

/** A tab whose project was left for another, by another tab, shows that one. */
function noteProject(answer: Response): void {
  const open = answer.headers.get(kProjectHeader) ?? ''
  if (shownProject && open && open !== shownProject) {
    sessionStorage.setItem(kMoved, 'yes')
    location.reload()
  } else if (open) shownProject = open
}

/** Sends the session's cookie by itself; throws ApiError with the server's words. */
export async function ask(path: string, init?: RequestInit): Promise<Response> {
  let answer: Response
  try {
    const own = { 'X-Keypose': '1', ...(shownProject && { [kProjectHeader]: shownProject }) }
    answer = await fetch(path, { ...init, headers: { ...own, ...init?.headers } })
  } catch {
    throw new ApiError(0, 'The studio does not answer. Is `keypose studio` still running?')
  }
  noteProject(answer)
  if (answer.ok) return answer
  let words = `${answer.status} ${answer.statusText}`
  try {
    words = ((await answer.json()) as { error: string }).error
  } catch {
    // not JSON: the status says it
  }
  throw new ApiError(answer.status, words)
}

export const get = async <T>(path: string): Promise<T> => (await ask(path)).json() as Promise<T>
/** Letters of a body that is sent even if the page is closed: browsers allow 64 kB of such bodies. */
const kMostAfterClose = 8e3
export const send = async <T>(method: string, path: string, body: unknown): Promise<T> => {
  const text = JSON.stringify(body)
  const answer = await ask(path, {
    method,
    headers: { 'Content-Type': 'application/json' },
    body: text,
    keepalive: text.length < kMostAfterClose,
  })
  return answer.json() as Promise<T>
}

const q = (values: Record<string, string>): string => new URLSearchParams(values).toString()

export const api = {
  project: () => get<Project>('/api/project'),
  /** Makes a project; only while there is none. */
  /** `few`: poses of few photographs, which the template is bent into. */
  createProject: (poses: string[], template: string, few: string[]) =>
    send<Project>('POST', '/api/project', { poses, template, few }),
  /** A project of films; `paint`, `bend`: video3d and follow. Its films are sent then. */
  createPerformance: (shots: string[], video3d: boolean, surface: boolean) =>
    send<{ made: boolean }>('POST', '/api/project', { shots, video3d, surface }),
  addShot: (shot: string) => send<{ added: boolean }>('POST', '/api/films/shot', { shot }),
  /** Adds one photograph to a pose's folder (only while no run is at work). */
  /** `replaces`: a photograph that goes to the bin, and whose name the new one gets. */
  addPhotograph: (pose: string, name: string, bytes: Blob, replaces = '') =>
    ask(`/api/photos?${q({ pose, name, ...(replaces && { replaces }) })}`, {
      method: 'PUT',
      body: bytes,
    }),
  /** out false: they are taken back. */
  leaveOut: (pose: string, names: string[], out: boolean) =>
    send<{ done: boolean }>('POST', '/api/photos/leave-out', { pose, names, out }),
  /** Into the bin; the entry's id. */
  deletePhotographs: (pose: string, names: string[]) =>
    send<{ id: string }>('POST', '/api/photos/delete', { pose, names }),
  again: (pose: string) => get<Again>(`/api/photos/again?${q({ pose })}`),
  bin: () => get<BinEntry[]>('/api/bin'),
  binUrl: (id: string, path: string, width: number) =>
    `/api/bin/picture?${q({ id, path, width: String(width) })}`,
  takeBack: (id: string) => send<{ done: boolean }>('POST', '/api/bin/take-back', { id }),
  /** few: it gets few photographs, which the template is bent into. */
  addPose: (pose: string, few: boolean) =>
    send<{ done: boolean }>('POST', '/api/poses/add', { pose, few }),
  renamePose: (pose: string, name: string) =>
    send<{ done: boolean }>('POST', '/api/poses/rename', { pose, name }),
  deletePose: (pose: string) => send<{ done: boolean }>('POST', '/api/poses/delete', { pose }),
  orderPoses: (poses: string[]) => send<{ done: boolean }>('POST', '/api/poses/order', { poses }),
  chooseTemplate: (pose: string) =>
    send<{ done: boolean }>('POST', '/api/poses/template', { pose }),
  chooseMethod: (pose: string, few: boolean) =>
    send<{ done: boolean }>('POST', '/api/poses/method', { pose, few }),

  steps: () => get<Steps>('/api/steps'),
  stages: () => get<Stage[]>('/api/stages'),
  explain: (step: string) => get<{ text: string }>(`/api/explain?${q({ step })}`),
  failedUrl: (picture: FailurePicture, width = 0) =>
    `/api/failed?${q({ ...picture, width: String(width) })}`,
  log: async (step: string) => (await ask(`/api/log?${q({ step })}`)).text(),
  run: (selection: { until?: string[]; from?: string[]; only?: string[]; force?: string[] }) =>
    send<{ started: boolean }>('POST', '/api/run', selection),
  stop: () => send<{ stopping: boolean }>('POST', '/api/stop', {}),
  /** value null: back to the default. pose '': for all poses. */
  setOption: (change: {
    step: string
    pose: string
    option: string
    value: string | null
    revision: string
  }) => send<{ revision: string }>('POST', '/api/options', change),

  photos: (pose: string) => get<Photograph[]>(`/api/photos?${q({ pose })}`),
  /**
   * width 0: full size. `captured`: what cameras and picks belong to, even if there is a newer one.
   * `version`: one that was shot again has another address.
   */
  photoUrl: (pose: string, name: string, width = 0, captured = false, version = '') => {
    const stage = captured ? 'capture' : ''
    return `/api/photo?${q({ pose, name, width: String(width), stage, version })}`
  },
  /** stage: 'capture' (before cameras are known) or 'masks' (the final ones) */
  maskUrl: (pose: string, name: string, stage: 'capture' | 'masks' = 'masks', version = '') =>
    `/api/mask?${q({ pose, name, stage, ...(version && { version }) })}`,
  /**
   * An 8-bit PNG of the photograph's size, white where the figure is; the new revision.
   * `photograph`: SHA-256 of the one that was painted over.
   */
  saveMask: async (
    pose: string,
    name: string,
    png: Blob,
    revision: string,
    photograph: string,
  ): Promise<string> => {
    const answer = await ask(`/api/mask?${q({ pose, name, revision, photograph })}`, {
      method: 'PUT',
      headers: { 'Content-Type': 'image/png' },
      body: png,
    })
    return ((await answer.json()) as { revision: string }).revision
  },
  /** Masks of older photographs: they hold for those of now, or are set aside as .old. */
  holdMasks: (pose: string, names: string[], hold: boolean) =>
    send<{ done: boolean }>('POST', '/api/masks/hold', { pose, names, hold }),
  figure: (pose: string) => get<Figure>(`/api/figure?${q({ pose })}`),
  /** Of those that are saved already only the text counts. */
  saveFigure: (pose: string, strokes: readonly FigureStroke[], revision: string) =>
    send<Figure>('PUT', `/api/figure?${q({ pose })}`, {
      revision,
      strokes: strokes.map(({ text, picture, figure, points }) =>
        text ? { text } : { picture, figure, points },
      ),
    }),
  /** A file below out/. `version`: one that was made anew has another address. */
  resultUrl: (path: string, version = '') =>
    `/results/${path.split('/').map(encodeURIComponent).join('/')}?${q({ version })}`,
  mending: (pose: string) => get<Mending>(`/api/mending?${q({ pose })}`),
  saveMending: (pose: string, strokes: readonly MendStroke[], revision: string) =>
    send<{ revision: string }>('PUT', `/api/mending?${q({ pose })}`, { revision, strokes }),
  meshToMend: async (pose: string) => (await ask(`/api/mending/mesh?${q({ pose })}`)).arrayBuffer(),
  /** float32: three a vertex, then two a stroke: vertices that it moved, and how far. */
  draftMending: async (pose: string, strokes: readonly MendStroke[]) => {
    const answer = await ask(`/api/mending/draft?${q({ pose })}`, {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ strokes }),
    })
    return answer.arrayBuffer()
  },
  cameras: (pose: string) => get<CameraView[]>(`/api/cameras?${q({ pose })}`),

  /** See view/mesh_data.ts for the bytes. */
  mesh: async (pose: string, what: string) =>
    (await ask(`/api/mesh?${q({ pose, what })}`)).arrayBuffer(),
  textureUrl: (pose: string) => `/api/texture?${q({ pose })}`,
  /** A grey picture in the texture's layout: white is seen well, black is made up. */
  confidenceUrl: (pose: string) => `/api/confidence?${q({ pose })}`,
  /** Distance of each vertex of the registered template to the pose's scan, over the diagonal. */
  fit: async (pose: string) =>
    new Float32Array(await (await ask(`/api/fit?${q({ pose })}`)).arrayBuffer()),

  /** How far the registered template's landmarks are from the pose's, over the diagonal. */
  pairFit: (pose: string) =>
    get<{ pairs: { name: string; distance: number }[] }>(`/api/landmarks/fit?${q({ pose })}`),

  picks: (pose: string) => get<Picks>(`/api/landmarks?${q({ pose })}`),
  savePicks: (pose: string, picks: Pick[], revision: string) =>
    send<Picks>('PUT', `/api/landmarks?${q({ pose })}`, { picks, revision }),
  savePixels: (pose: string, pixels: PhotoPick[], revision: string) =>
    send<Picks>('PUT', `/api/landmarks?${q({ pose })}`, { pixels, revision }),
  photoFit: (pose: string) => get<PhotoFit>(`/api/landmarks/photographs?${q({ pose })}`),
  /** Takes MeshLab's .pp, Wrap's landmarks, or our JSON. */
  importPicks: (pose: string, name: string, text: string) =>
    send<Picks>('POST', `/api/landmarks/import?${q({ pose })}`, { name, text }),
  exportPicksUrl: (pose: string, format: 'pp' | 'wrap' | 'json') =>
    `/api/landmarks/export?${q({ pose, format })}`,
  mirroredPicks: (pose: string) =>
    get<{ misfit: number; mirrored: Mirrored[] }>(`/api/landmarks/mirrored?${q({ pose })}`),
  suggest: (pose: string, count: number) =>
    send<{ pairs: Suggestion[]; why_none: string }>('POST', '/api/landmarks/suggest', {
      pose,
      count,
    }),
  /** Where one more landmark would help most; empty before the pose was registered. */
  advice: (pose: string) => get<Advice[]>(`/api/landmarks/advice?${q({ pose })}`),

  shoot: () => get<ShootStory>('/api/shoot'),
  startShoot: (setup: ShootSetup) => send<{ started: boolean }>('POST', '/api/shoot/start', setup),
  tellShoot: (command: { command: string; [field: string]: unknown }) =>
    send<{ sent: boolean }>('POST', '/api/shoot/command', command),
  interruptShoot: () => send<{ sent: boolean }>('POST', '/api/shoot/interrupt', {}),
  /** Another frame has another address. */
  liveUrl: (frame: number) => `/api/shoot/live?${q({ frame: String(frame) })}`,
  /** A photograph as it landed; `version` when it was shot again. width 0: full size */
  landedUrl: (path: string, version: number, width = 0) =>
    `/api/shoot/picture?${q({ path, width: String(width), version: String(version) })}`,

  sound: () => get<ProjectSound | null>('/api/sound'),
  /** `version`: another sound has another address. */
  soundBytes: async (version: string) =>
    (await ask(`/api/sound/file?${q({ version })}`)).blob(),
  saveSound: async (name: string, bytes: Blob): Promise<ProjectSound> => {
    const answer = await ask(`/api/sound?${q({ name })}`, { method: 'PUT', body: bytes })
    return answer.json() as Promise<ProjectSound>
  },
  moveSound: (at: number) => send<ProjectSound>('PUT', '/api/sound/at', { at }),
  removeSound: () => send<null>('PUT', '/api/sound/remove', {}),
  timeline: () => get<Timeline>('/api/timeline'),
  saveTimeline: (timeline: Timeline) => send<Timeline>('PUT', '/api/timeline', timeline),
  // shot: of a performance; '' for the animation between the keys
  frames: (shot = '') => get<Frames>(`/api/frames?${q({ shot })}`),
  /** count x vertices x 3, in the order of the template's vertices */
  positions: async (shot = '') =>
    new Float32Array(await (await ask(`/api/frames/positions?${q({ shot })}`)).arrayBuffer()),
  firstFrame: async (shot: string) =>
    (await ask(`/api/frames/first?${q({ shot })}`)).arrayBuffer(),
  /** The texture of a frame of the video; `version`: a new one has another address. */
  frameTexture: async (shot: string, frame: number, width: number, version: string) => {
    const asked = { shot, frame: String(frame), width: String(width), version }
    return (await ask(`/api/frames/texture?${q(asked)}`)).blob()
  },
  films: (shot: string) => get<Films>(`/api/films?${q({ shot })}`),
  /** A frame of a film. width 0: full size */
  filmUrl: (shot: string, camera: string, frame: number, width = 0) =>
    `/api/films/frame?${q({ shot, camera, frame: String(frame), width: String(width) })}`,
  filmMaskUrl: (shot: string, camera: string, frame: number, version: string) =>
    `/api/films/mask?${q({ shot, camera, frame: String(frame), version })}`,
  ownTextureUrl: (shot: string, version: number) =>
    `/api/frames/texture?${q({ shot, version: String(version) })}`,
  results: () => get<{ path: string; label: string; bytes: number }[]>('/api/results'),
  /** Shows the folder in the desktop's file manager. */
  reveal: (path: string) => send<{ shown: boolean }>('POST', '/api/reveal', { path }),

  // Painted on the template's 'mesh'. GET and PUT answer alike; 409 if the revision is not the
  // file's. values: one positive factor a vertex, 1 as by default; null: nothing painted.
  stiffness: () => get<{ revision: string; values: number[] | null }>('/api/stiffness'),
  saveStiffness: (values: number[] | null, revision: string) =>
    send<{ revision: string }>('PUT', '/api/stiffness', { values, revision }),
  /** Vertices by the region's name. */
  regions: () => get<{ revision: string; regions: Record<string, number[]> }>('/api/regions'),
  saveRegions: (regions: Record<string, number[]>, revision: string) =>
    send<{ revision: string }>('PUT', '/api/regions', { regions, revision }),
}

/** What the server tells by itself. */
export type StudioEvent =
  | { type: 'run'; line: RunLine }
  | { type: 'run_ended'; exit_code: number; message: string }
  | { type: 'project' } // pipeline.yaml or another file of the project has changed
  | { type: 'shoot'; number: number; event: ShootEvent }
  | { type: 'shoot_ended'; number: number; exit_code: number; message: string }
  | { type: 'armature'; number: number; event: { event: string } }
  | { type: 'armature_ended'; number: number; exit_code: number; message: string }
  | { type: 'armature_baked'; exit_code: number; message: string }
  | { type: 'writers'; count: number } // tabs that have the project open
  | { type: 'connection'; open: boolean }

/** One line of `keypose run --progress jsonl`. */
export interface RunLine {
  event: string
  step?: string
  status?: string
  fraction?: number
  what?: string
  text?: string
  seconds?: number
  overall?: number
  seconds_left?: number
  seconds_left_range?: [number, number]
  reasons?: string[]
  [key: string]: unknown
}

const kEventTypes = [
  'run',
  'run_ended',
  'project',
  'writers',
  'shoot',
  'shoot_ended',
  'armature',
  'armature_ended',
  'armature_baked',
]

/**
 * Calls `listen` with every event until the returned function is called. Connects again by itself.
 */
export function events(listen: (event: StudioEvent) => void): () => void {
  const source = new EventSource('/api/events')
  for (const type of kEventTypes) {
    source.addEventListener(type, (message) => {
      const data = JSON.parse((message as MessageEvent<string>).data) as object
      listen((type === 'run' ? { type, line: data } : { type, ...data }) as StudioEvent)
    })
  }
  source.onopen = () => listen({ type: 'connection', open: true })
  source.onerror = () => listen({ type: 'connection', open: false })
  return () => source.close()
}
